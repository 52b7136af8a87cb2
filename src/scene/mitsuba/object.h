// The properties of an object of a Mitsuba scene; every complaint names file and line.
#pragma once

#include "scene/mitsuba/document.h"

#include <glm/glm.hpp>
#include <span>

namespace cmpg {

class MitsubaObject {
  public:
    MitsubaObject(const MitsubaDocument& document, const MitsubaElement& element) : document_(&document), element_(&document.resolve(element)) {}

    const MitsubaElement& element() const { return *element_; }
    const MitsubaDocument& document() const { return *document_; }
    const std::string& tag() const { return element_->tag; }
    const std::string& type() const { return element_->type; }
    const std::string& id() const { return element_->id; }

    // The property's element; nullptr if it is not given. Each marks the property as read.
    const MitsubaElement* find(const std::string& name) const;
    double real(const std::string& name, double fallback, double lowest = -1e30, double highest = 1e30) const;
    std::int64_t integer(const std::string& name, std::int64_t fallback, std::int64_t lowest, std::int64_t highest) const;
    bool boolean(const std::string& name, bool fallback) const;
    std::string string(const std::string& name, const std::string& fallback) const;
    std::string oneOf(const std::string& name, std::initializer_list<const char*> values) const; // the first is the default
    std::optional<glm::dvec3> point(const std::string& name) const; // or vector
    std::optional<glm::dmat4> transform(const std::string& name) const;

    // Nested objects, by tag, references followed; each marks them as read.
    std::vector<MitsubaObject> objects(const std::string& tag) const;

    // Properties and nested objects that nobody read, as "property (scene.xml:12)".
    std::vector<std::string> unread() const;
    // What is known and has no effect here.
    void ignore(std::initializer_list<const char*> names) const;

    [[noreturn]] void fail(const std::string& what, const std::string& cause = "", const std::string& remedy = "") const {
        document_->fail(*element_, what, cause, remedy);
    }
    // "<bsdf type="diffuse"> ..." as the beginning of a message.
    std::string title() const { return "<" + tag() + " type=\"" + type() + "\">"; }

  private:
    const MitsubaDocument* document_;
    const MitsubaElement* element_;
    mutable std::set<const MitsubaElement*> read_;
};

// Two vectors across a unit vector, at right angles, that Mitsuba chooses where the file leaves them open (Duff et al. 2017).
std::pair<glm::dvec3, glm::dvec3> mitsubaFrame(const glm::dvec3& n);

// Numbers between commas or spaces; at least `fewest`, at most `most`, finite and within +-1e30.
std::vector<double> mitsubaNumbers(const MitsubaDocument& document, const MitsubaElement& element, const std::string& text, std::size_t fewest,
                                   std::size_t most);
// The value of <rgb>, <spectrum> or <float>. `emission`: a uniform spectrum is white as equal energy is, not as sRGB is.
glm::dvec3 mitsubaColor(const MitsubaDocument& document, const MitsubaElement& element, bool emission);

} // namespace cmpg
