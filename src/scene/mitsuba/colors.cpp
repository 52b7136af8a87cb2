// Colours that a Mitsuba scene writes in other ways than <rgb>.
#include "scene/mitsuba/colors.h"

#include "scene/image.h"
#include "scene/mitsuba/object.h"

#include <charconv>

namespace cmpg {
namespace {

// "#rrggbb", or numbers; encoded either way.
glm::dvec3 encodedColor(const MitsubaDocument& document, const MitsubaElement& element, const std::string& text) {
    const std::size_t hash = text.find('#');
    if (hash == std::string::npos) {
        const std::vector<double> v = mitsubaNumbers(document, element, text, 1, 3);
        if (v.size() == 2)
            document.fail(element, "<srgb> takes one number or three");
        return v.size() == 1 ? glm::dvec3(v[0]) : glm::dvec3(v[0], v[1], v[2]);
    }
    constexpr std::size_t kDigits = 6;
    std::uint32_t code = 0;
    const char *first = text.data() + hash + 1, *last = text.data() + text.size();
    const auto [end, error] = std::from_chars(first, last, code, 16);
    if (hash != 0 || text.size() != kDigits + 1 || error != std::errc() || end != last)
        document.fail(element, "<srgb> has the value \"" + text.substr(0, 64) + "\", which is no colour", "", "write #rrggbb, or three numbers");
    return glm::dvec3(code >> 16, code >> 8 & 255, code & 255) / 255.0;
}

// Of the element's children; each must have one of these names.
glm::dvec3 factorOf(const MitsubaDocument& document, const MitsubaElement& element, const char* color, const char* factor) {
    glm::dvec3 product(1);
    for (const MitsubaElement* child : element.children) {
        if (child->name != color && child->name != factor)
            document.fail(*child, "the spectrum " + element.type + " has no property " + child->name.substr(0, 64));
        product *= mitsubaColor(document, document.resolve(*child), false);
    }
    return product;
}

} // namespace

void becomeRgb(const MitsubaDocument& document, MitsubaElement& element) {
    glm::dvec3 color;
    if (element.tag == "srgb") {
        const std::string* text = element.attribute("value");
        if (!text)
            document.fail(element, "<srgb> needs a value");
        color = encodedColor(document, element, *text);
        for (int i = 0; i < 3; ++i)
            color[i] = double(srgbDecode(float(color[i])));
    } else if (element.tag == "spectrum" && element.isObject()) {
        const bool uniform = element.type == "uniform", srgb = element.type == "srgb";
        if (!uniform && !srgb && element.type != "d65")
            document.fail(element, "the spectrum " + element.type.substr(0, 64) + " is not supported", "colours are RGB here", "give it as <rgb>");
        if ((uniform || srgb) && element.children.empty())
            document.fail(element, "the spectrum " + element.type + " needs a " + (uniform ? "value" : "color"));
        color = uniform ? factorOf(document, element, "value", "value") : factorOf(document, element, "color", srgb ? "color" : "scale");
    } else {
        return;
    }
    const bool grey = color.x == color.y && color.y == color.z; // then also a number
    std::string value;
    for (int i = 0; i < (grey ? 1 : 3); ++i) {
        char number[32];
        std::snprintf(number, sizeof number, "%.9g", color[i]);
        value += (i ? ", " : "") + std::string(number);
    }
    element.tag = "rgb";
    element.type.clear();
    element.children.clear();
    element.attributes = {{"value", value}};
}

} // namespace cmpg
