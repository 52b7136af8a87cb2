// Reading untrusted JSON: every access is checked and every complaint names the place in the file.
#include "scene/gltf/json_view.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmpg {

void JsonView::fail(const std::string& what, const std::string& cause, const std::string& remedy) const {
    throw Error(ErrorKind::Input, *file_ + ": " + (place_.empty() ? "the top level" : place_) + " " + what, cause, remedy);
}

JsonView JsonView::operator[](const std::string& key) const {
    const std::string place = place_.empty() ? key : place_ + "." + key;
    if (!exists()) return {nullptr, *file_, place};
    if (!isObject()) fail("is not an object");
    const auto found = value_->find(key);
    return {found == value_->end() ? nullptr : &*found, *file_, place};
}

std::uint32_t JsonView::size() const {
    if (!exists()) return 0;
    if (!value_->is_array()) fail("is not an array");
    if (value_->size() >= std::numeric_limits<std::uint32_t>::max()) fail("has too many entries");
    return std::uint32_t(value_->size());
}

JsonView JsonView::at(std::uint32_t i) const {
    const std::string place = place_ + "[" + std::to_string(i) + "]";
    if (i >= size()) JsonView(nullptr, *file_, place).fail("does not exist");
    return {&(*value_)[i], *file_, place};
}

std::vector<std::string> JsonView::keys() const {
    std::vector<std::string> keys;
    if (!exists()) return keys;
    if (!isObject()) fail("is not an object");
    for (const auto& [key, value] : value_->items()) keys.push_back(key);
    return keys;
}

const JsonView& JsonView::required() const {
    if (!exists()) fail("is missing");
    return *this;
}

double JsonView::value() const {
    if (!value_->is_number()) fail("is not a number");
    return value_->get<double>();
}

void JsonView::number(float lowest, float highest) const {
    if (!exists()) return;
    const double v = value();
    if (!(std::abs(v) <= double(kAny))) fail("is too large a number");
    const auto shown = [](double x) { return Json(float(x)).dump(); };
    if (!(float(v) >= lowest && float(v) <= highest))
        fail("is " + shown(v) + ", but must lie between " + shown(lowest) + " and " + shown(highest));
}

void JsonView::numbers(std::uint32_t count) const {
    if (exists() && size() != count) fail("has " + std::to_string(size()) + " entries, but must have " + std::to_string(count));
    each([](const JsonView& entry) { entry.number(); });
}

std::uint64_t JsonView::integer(std::uint64_t lowest, std::uint64_t highest) const {
    if (!exists()) return lowest;
    const double v = value();
    if (!(v >= double(lowest)) || v != std::floor(v) || v > double(highest))
        fail("is not an integer from " + std::to_string(lowest) + " to " + std::to_string(highest));
    return std::uint64_t(v);
}

std::optional<std::uint32_t> JsonView::index(std::uint32_t count, const char* ofWhat) const {
    if (!exists()) return std::nullopt;
    const double v = value();
    if (!(v >= 0) || v != std::floor(v) || v >= double(count))
        fail("names " + std::string(ofWhat) + " " + value_->dump() + ", but there are " + std::to_string(count));
    return std::uint32_t(v);
}

void JsonView::oneOf(const Json& allowed) const {
    if (exists() && std::find(allowed.begin(), allowed.end(), *value_) == allowed.end())
        fail("is " + value_->dump().substr(0, 80) + ", but must be one of " + allowed.dump());
}

bool JsonView::boolean(bool fallback) const {
    if (!exists()) return fallback;
    if (!value_->is_boolean()) fail("is neither true nor false");
    return value_->get<bool>();
}

std::string JsonView::string(const std::string& fallback) const {
    if (!exists()) return fallback;
    if (!value_->is_string()) fail("is not a string");
    return value_->get<std::string>();
}

} // namespace cmpg
