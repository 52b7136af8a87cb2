// The properties of an object of a Mitsuba scene.
#include "scene/mitsuba/object.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace cmpg {
namespace {

constexpr double kLargest = 1e30;

bool separates(char c) { return c == ',' || c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

const std::string& valueOf(const MitsubaDocument& d, const MitsubaElement& e) {
    const std::string* value = e.attribute("value");
    if (!value)
        d.fail(e, "<" + e.tag + "> needs a value");
    return *value;
}

double numberOf(const MitsubaDocument& d, const MitsubaElement& e, const std::string& text) { return mitsubaNumbers(d, e, text, 1, 1)[0]; }

// x, y and z as attributes, or all in one.
glm::dvec3 vectorOf(const MitsubaDocument& d, const MitsubaElement& e, double absent) {
    if (const std::string* value = e.attribute("value")) {
        const std::vector<double> v = mitsubaNumbers(d, e, *value, 1, 3);
        if (v.size() == 2)
            d.fail(e, "<" + e.tag + "> takes one number or three");
        return v.size() == 1 ? glm::dvec3(v[0]) : glm::dvec3(v[0], v[1], v[2]);
    }
    glm::dvec3 out(absent);
    int i = 0;
    for (const char* key : {"x", "y", "z"}) {
        if (const std::string* text = e.attribute(key))
            out[i] = numberOf(d, e, *text);
        ++i;
    }
    return out;
}

glm::dvec3 triple(const MitsubaDocument& d, const MitsubaElement& e, const char* key) {
    const std::string* text = e.attribute(key);
    if (!text)
        d.fail(e, "<" + e.tag + "> needs " + key);
    const std::vector<double> v = mitsubaNumbers(d, e, *text, 3, 3);
    return {v[0], v[1], v[2]};
}

glm::dmat4 lookAt(const MitsubaDocument& d, const MitsubaElement& e) {
    const glm::dvec3 origin = triple(d, e, "origin"), target = triple(d, e, "target");
    const glm::dvec3 forward = glm::normalize(target - origin);
    glm::dvec3 up = e.attribute("up") ? triple(d, e, "up") : glm::dvec3(0);
    if (!(glm::length(up) > 0))
        up = mitsubaFrame(forward).first;
    const glm::dvec3 left = glm::normalize(glm::cross(up, forward)), above = glm::cross(forward, left);
    const double sum = glm::dot(left, left) + glm::dot(forward, forward);
    if (!std::isfinite(sum))
        d.fail(e, "<lookat> looks nowhere", "origin and target are the same point, or up is along the view", "change one of them");
    return {glm::dvec4(left, 0), glm::dvec4(above, 0), glm::dvec4(forward, 0), glm::dvec4(origin, 1)};
}

glm::dmat4 matrixOf(const MitsubaDocument& d, const MitsubaElement& e) {
    const std::vector<double> v = mitsubaNumbers(d, e, valueOf(d, e), 9, 16);
    if (v.size() != 9 && v.size() != 16)
        d.fail(e, "<matrix> takes 9 or 16 numbers, not " + std::to_string(v.size()));
    const int n = v.size() == 9 ? 3 : 4;
    glm::dmat4 m(1);
    for (int row = 0; row < n; ++row)
        for (int column = 0; column < n; ++column)
            m[column][row] = v[std::size_t(row * n + column)];
    constexpr double kRounding = 1e-6;
    if (std::abs(m[0][3]) > kRounding || std::abs(m[1][3]) > kRounding || std::abs(m[2][3]) > kRounding || std::abs(m[3][3] - 1) > kRounding)
        d.fail(e, "<matrix> is not an affine transform");
    m[0][3] = m[1][3] = m[2][3] = 0;
    m[3][3] = 1;
    return m;
}

glm::dmat4 step(const MitsubaDocument& d, const MitsubaElement& e) {
    if (e.tag == "translate")
        return glm::translate(glm::dmat4(1), vectorOf(d, e, 0));
    if (e.tag == "scale")
        return glm::scale(glm::dmat4(1), vectorOf(d, e, 1));
    if (e.tag == "rotate") {
        const glm::dvec3 axis = vectorOf(d, e, 0);
        const std::string* angle = e.attribute("angle");
        if (!angle)
            d.fail(e, "<rotate> needs an angle");
        const double radians = glm::radians(numberOf(d, e, *angle));
        // Of a texture: in its plane.
        const glm::dvec3 about = glm::length(axis) > 0 ? axis : glm::dvec3(0, 0, 1);
        return glm::rotate(glm::dmat4(1), radians, glm::normalize(about));
    }
    if (e.tag == "lookat")
        return lookAt(d, e);
    if (e.tag == "matrix")
        return matrixOf(d, e);
    d.fail(e, "<" + e.tag + "> is no part of a transform", "", "use translate, scale, rotate, lookat or matrix");
}

} // namespace

std::pair<glm::dvec3, glm::dvec3> mitsubaFrame(const glm::dvec3& n) {
    const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

std::vector<double> mitsubaNumbers(const MitsubaDocument& d, const MitsubaElement& e, const std::string& text, std::size_t fewest, std::size_t most) {
    std::vector<double> numbers;
    const char *at = text.data(), *const end = at + text.size();
    for (;;) {
        while (at < end && separates(*at))
            ++at;
        if (at == end)
            break;
        if (*at == '+')
            ++at;
        double v = 0;
        const auto [next, error] = std::from_chars(at, end, v);
        const bool vanishes = error == std::errc::result_out_of_range && std::abs(v) < 1; // too small for a number: 0
        if ((error != std::errc() && !vanishes) || (next < end && !separates(*next)) || !(std::abs(v) <= kLargest) || numbers.size() == most)
            d.fail(e, "<" + e.tag + "> has the value \"" + text.substr(0, 64) + "\", which is not " +
                          (most == 1 ? "a number" : "up to " + std::to_string(most) + " numbers"));
        numbers.push_back(v);
        at = next;
    }
    if (numbers.size() < fewest)
        d.fail(e, "<" + e.tag + "> has the value \"" + text.substr(0, 64) + "\", which is not " +
                      (fewest == 1 ? "a number" : std::to_string(fewest) + " numbers"));
    return numbers;
}

glm::dvec3 mitsubaColor(const MitsubaDocument& d, const MitsubaElement& e, bool emission) {
    const std::string& text = valueOf(d, e);
    if (e.tag == "float" || e.tag == "integer")
        return glm::dvec3(numberOf(d, e, text));
    if (e.tag == "spectrum" && text.find(':') != std::string::npos)
        d.fail(e, "spectra by wavelength are not supported", "colours are RGB here", "give it as <rgb>");
    if (e.tag != "rgb" && e.tag != "spectrum")
        d.fail(e, "<" + e.tag + "> is no colour", "", "use rgb, float, or a texture");
    if (text.find('#') != std::string::npos)
        d.fail(e, "colours in hexadecimal are not supported", "Mitsuba 3 does not read them either", "give three linear numbers, or <srgb>");
    const std::vector<double> v = mitsubaNumbers(d, e, text, 1, 3);
    if (v.size() == 2)
        d.fail(e, "<" + e.tag + "> takes one number or three");
    if (v.size() == 3)
        return {v[0], v[1], v[2]};
    // The same power at all wavelengths is warmer than sRGB's white: CIE illuminant E in linear sRGB, as Mitsuba's rgb mode has it.
    const glm::dvec3 equalEnergy(1.2047939, 0.9482910, 0.9089161);
    return emission && e.tag == "spectrum" ? v[0] * equalEnergy : glm::dvec3(v[0]);
}

const MitsubaElement* MitsubaObject::find(const std::string& name) const {
    const MitsubaElement* found = nullptr;
    for (const MitsubaElement* child : element_->children)
        if (child->name == name) {
            if (found)
                document_->fail(*child, "the property " + name + " is given twice");
            found = child;
            read_.insert(child);
        }
    return found;
}

double MitsubaObject::real(const std::string& name, double fallback, double lowest, double highest) const {
    const MitsubaElement* e = find(name);
    if (!e)
        return fallback;
    if (e->tag != "float" && e->tag != "integer" && !(e->tag == "spectrum" || e->tag == "rgb"))
        document_->fail(*e, "the property " + name + " of " + title() + " must be a number");
    const double v = numberOf(*document_, *e, valueOf(*document_, *e));
    if (!(v >= lowest && v <= highest)) {
        char text[128];
        std::snprintf(text, sizeof text, "the property %.40s is %g, outside of [%g, %g]", name.c_str(), v, lowest, highest);
        document_->fail(*e, text);
    }
    return v;
}

std::int64_t MitsubaObject::integer(const std::string& name, std::int64_t fallback, std::int64_t lowest, std::int64_t highest) const {
    const double v = real(name, double(fallback), double(lowest), double(highest));
    if (v != std::floor(v))
        document_->fail(*find(name), "the property " + name + " must be a whole number");
    return std::int64_t(v);
}

bool MitsubaObject::boolean(const std::string& name, bool fallback) const {
    const MitsubaElement* e = find(name);
    if (!e)
        return fallback;
    const std::string& value = valueOf(*document_, *e);
    if (value != "true" && value != "false" && value != "True" && value != "False")
        document_->fail(*e, "the property " + name + " must be true or false, not \"" + value.substr(0, 64) + "\"");
    return value == "true" || value == "True";
}

std::string MitsubaObject::string(const std::string& name, const std::string& fallback) const {
    const MitsubaElement* e = find(name);
    return e ? valueOf(*document_, *e) : fallback;
}

std::string MitsubaObject::oneOf(const std::string& name, std::initializer_list<const char*> values) const {
    const std::string value = string(name, *values.begin());
    std::string list;
    for (const char* known : values) {
        if (value == known)
            return value;
        list += (list.empty() ? "" : ", ") + std::string(known);
    }
    document_->fail(*find(name), "the property " + name + " is \"" + value.substr(0, 64) + "\"", "", "use one of " + list);
}

std::optional<glm::dvec3> MitsubaObject::point(const std::string& name) const {
    const MitsubaElement* e = find(name);
    if (!e)
        return {};
    return vectorOf(*document_, *e, 0);
}

std::optional<glm::dmat4> MitsubaObject::transform(const std::string& name) const {
    const MitsubaElement* e = find(name);
    if (!e)
        return {};
    if (e->tag != "transform")
        document_->fail(*e, "the property " + name + " must be a <transform>");
    glm::dmat4 m(1);
    for (const MitsubaElement* child : e->children) {
        m = step(*document_, *child) * m;
        for (int i = 0; i < 16; ++i)
            if (!(std::abs(m[i / 4][i % 4]) <= kLargest))
                document_->fail(*child, "the transform leaves the range of numbers", "it scales too much", "check the transform");
    }
    return m;
}

std::vector<MitsubaObject> MitsubaObject::objects(const std::string& tag) const {
    std::vector<MitsubaObject> found;
    for (const MitsubaElement* child : element_->children)
        if (const MitsubaElement& target = document_->resolve(*child); target.tag == tag && !target.type.empty()) {
            read_.insert(child);
            found.emplace_back(*document_, *child);
        }
    return found;
}

std::vector<std::string> MitsubaObject::unread() const {
    std::vector<std::string> names;
    for (const MitsubaElement* child : element_->children)
        if (!read_.contains(child))
            names.push_back((child->name.empty() ? "<" + child->tag + ">" : child->name) + " (" + document_->place(*child) + ")");
    return names;
}

void MitsubaObject::ignore(std::initializer_list<const char*> names) const {
    for (const char* name : names)
        for (const MitsubaElement* child : element_->children)
            if (child->name == name)
                read_.insert(child);
}

} // namespace cmpg
