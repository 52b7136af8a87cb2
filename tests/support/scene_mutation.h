// Random changes of glTF scenes that embed their data, as a generator of random numbers says: any value of the JSON, any word of the data.
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

namespace cmpg::test {

constexpr const char* kBase64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

// Of whole groups of three bytes; zeros fill up the last.
inline std::string toBase64(std::string bytes) {
    bytes.resize((bytes.size() + 2) / 3 * 3);
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::uint32_t group = std::uint32_t(std::uint8_t(bytes[i])) << 16 | std::uint32_t(std::uint8_t(bytes[i + 1])) << 8 | std::uint8_t(bytes[i + 2]);
        for (const int shift : {18, 12, 6, 0})
            text += kBase64[group >> shift & 63];
    }
    return text;
}

inline std::string fromBase64(const std::string& text) {
    std::string bytes;
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char* const digit = std::strchr(kBase64, text[i]);
        group = group << 6 | (digit && *digit ? std::uint32_t(digit - kBase64) : 0);
        if (i % 4 == 3)
            for (const int shift : {16, 8, 0})
                bytes += char(group >> shift & 255);
    }
    return bytes;
}

class SceneMutation {
  public:
    using Json = nlohmann::json;

    explicit SceneMutation(std::uint32_t seed) : random_(seed) {}

    // One change.
    void apply(Json& root) {
        places_.clear();
        collect(root, root);
        if (places_.empty())
            return;
        const auto [parent, value] = pick();
        Json other = *pick().value; // a copy: it may hold the value, or be held by it
        switch (below(12)) { // most often what still may load
        case 0:
            *value = std::move(other);
            break;
        case 1: // of another type
            *value = std::vector<Json>{nullptr, true, "x", Json::array(), Json::object(), 0, 1.5}[below(7)];
            break;
        case 2:
            remove(*parent, value);
            break;
        case 3: // one more of a list
            if (parent->is_array())
                parent->push_back(std::move(other));
            break;
        case 4:
            if (parent->is_array() && parent->size() > 1)
                std::swap((*parent)[below(parent->size())], (*parent)[below(parent->size())]);
            break;
        default:
            alter(*value);
            break;
        }
    }

  private:
    struct Place {
        Json *parent, *value;
    };

    std::size_t below(std::size_t n) { return random_() % n; }
    Place pick() { return places_[below(places_.size())]; }

    void collect(Json& parent, Json& value) {
        if (&parent != &value)
            places_.push_back({&parent, &value});
        if (value.is_structured())
            for (Json& child : value)
                collect(value, child);
    }

    // Another value of its kind.
    void alter(Json& value) {
        constexpr double kNumbers[] = {0, 1, -1, 2, 3, 0.5, 1e-30, 1e-7, 1e7, 1e30, -1e30, 3.4e38, 1e300, 255, 65535, 2147483647, 4294967295};
        if (value.is_number())
            value = below(4) == 0 ? Json(value.get<double>() * (below(2) ? -1 : 1.25)) : value.is_number_float() || below(2) ? Json(kNumbers[below(17)]) : Json(below(8));
        else if (value.is_boolean())
            value = !value.get<bool>();
        else if (value.is_string())
            alterText(value.get_ref<std::string&>());
    }

    // Embedded data: a word of it, or a byte; other texts: a character.
    void alterText(std::string& text) {
        constexpr std::uint32_t kWords[] = {0, 1, 0x3f800000, 0xbf800000, 0x7f7fffff, 0xff7fffff, 0x7fc00000, 0x00800000, 0x80000000, 0x5f000000, 0x20000000};
        if (text.rfind("data:", 0) != 0) {
            if (!text.empty())
                text[below(text.size())] = char(32 + below(95));
            return;
        }
        const std::size_t begin = text.find(',') + 1;
        std::string bytes = fromBase64(text.substr(begin));
        for (std::size_t i = 0; i <= below(4) && bytes.size() >= 4; ++i) {
            const std::uint32_t word = below(2) ? kWords[below(std::size(kWords))] : std::uint32_t(random_());
            std::memcpy(&bytes[below(bytes.size() / 4) * 4], &word, 1 + below(4));
        }
        text = text.substr(0, begin) + toBase64(bytes);
    }

    static void remove(Json& parent, const Json* value) {
        for (auto i = parent.begin(); i != parent.end(); ++i)
            if (&*i == value) {
                parent.erase(i);
                return;
            }
    }

    std::mt19937 random_;
    std::vector<Place> places_;
};

} // namespace cmpg::test
