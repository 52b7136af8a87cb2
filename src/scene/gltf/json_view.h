// Reading untrusted JSON: every access is checked and every complaint names the place in the file.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cmpg {

using Json = nlohmann::json;

// A JSON value and where it stands ("materials[3].alphaCutoff"). An absent value is a view too, of nothing.
class JsonView {
  public:
    JsonView(const Json* value, const std::string& file, std::string place) : value_(value), file_(&file), place_(std::move(place)) {}

    bool exists() const { return value_ != nullptr; }
    bool isObject() const { return exists() && value_->is_object(); }
    const std::string& place() const { return place_; }

    // Member of an object, absent if there is none; fails if this is present and no object.
    JsonView operator[](const std::string& key) const;
    // Arrays; an absent one is empty.
    std::uint32_t size() const;
    JsonView at(std::uint32_t i) const;
    template <class F> void each(const F& f) const {
        for (std::uint32_t i = 0, end = size(); i < end; ++i) f(at(i));
    }
    std::vector<std::string> keys() const;

    // Each fails if the value has another type or lies elsewhere; an absent one is right unless required(), and the lowest
    // integer.
    const JsonView& required() const;
    void number(float lowest = -kAny, float highest = kAny) const;
    void numbers(std::uint32_t count) const;
    std::uint64_t integer(std::uint64_t lowest, std::uint64_t highest) const; // 3.0 is one, too
    // Index into an array of `count` things; nullopt if absent.
    std::optional<std::uint32_t> index(std::uint32_t count, const char* ofWhat) const;
    void oneOf(const Json& allowed) const;
    bool boolean(bool fallback) const;
    std::string string() const { return required().string(""); }
    std::string string(const std::string& fallback) const;

    [[noreturn]] void fail(const std::string& what, const std::string& cause = "the file is damaged or was written by a faulty exporter",
                           const std::string& remedy = "re-export the scene") const;

  private:
    static constexpr float kAny = std::numeric_limits<float>::max();
    double value() const;

    const Json* value_;
    const std::string* file_; // outlives every view of it
    std::string place_;
};

} // namespace cmpg
