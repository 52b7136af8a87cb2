// A Mitsuba scene as a tree of elements, read safely: variables replaced, included files in place, names in the style of version 3, colours of other
// forms as <rgb>.
#pragma once

#include "scene/file_io.h"

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace cmpg {

struct MitsubaElement {
    std::string tag;  // "bsdf", "float" ...; of objects in the style of version 3: "sensor", not "camera"
    std::string type; // of objects: the plugin
    std::string name; // of properties, and of nested objects that are one
    std::string id;
    std::map<std::string, std::string> attributes; // the others: value, x, y, z, filename ...
    std::vector<const MitsubaElement*> children;
    std::uint32_t file = 0, line = 0;
    std::size_t offset = 0; // in the file, of the tag's name

    bool isObject() const { return !type.empty(); }
    // An attribute; nothing where it is absent.
    const std::string* attribute(const std::string& key) const;
};

class MitsubaDocument {
  public:
    // `definitions`: values of variables, in place of their defaults.
    MitsubaDocument(const std::filesystem::path& file, const std::map<std::string, std::string>& definitions);
    MitsubaDocument(const MitsubaDocument&) = delete; // elements point into it
    MitsubaDocument& operator=(const MitsubaDocument&) = delete;

    // What stands in the scene, included files in place.
    const std::vector<const MitsubaElement*>& contents() const { return root_.children; }
    // The element itself, or what it refers to.
    const MitsubaElement& resolve(const MitsubaElement& element) const;
    // What a <ref> refers to, by its id or an alias; nothing where it dangles.
    const MitsubaElement* target(const MitsubaElement& ref) const;
    // Definitions that no variable of the scene has.
    std::vector<std::string> unusedDefinitions() const;
    const std::string& name() const { return files_.front().name; }

    // "scene.xml:12"
    std::string place(const MitsubaElement& element) const;
    [[noreturn]] void fail(const MitsubaElement& element, const std::string& what, const std::string& cause = "",
                           const std::string& remedy = "") const;

    // A file that the scene names, inside the scene's folder.
    std::filesystem::path path(const MitsubaElement& element, const std::string& relative) const;
    Bytes read(const MitsubaElement& element, const std::string& relative) const;
    const std::filesystem::path& folder() const { return folder_; }
    // The file itself and those that it includes or names, inside its folder.
    std::vector<std::filesystem::path> files() const;

  private:
    struct File {
        std::string name;
        std::filesystem::path path; // links followed
        std::vector<std::size_t> lines; // offsets of line breaks
        bool old = false;               // of a version before 2
    };
    class Reader;

    std::filesystem::path folder_;
    std::deque<File> files_;
    std::deque<MitsubaElement> elements_;
    MitsubaElement root_;
    std::map<std::string, const MitsubaElement*> ids_;
    std::map<std::string, std::string> variables_;
    std::set<std::string> given_, used_;
};

} // namespace cmpg
