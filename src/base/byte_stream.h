// Numbers and texts to bytes, little endian, and back from bytes that nobody trusts.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

class ByteWriter {
  public:
    void put(std::unsigned_integral auto value) {
        for (std::size_t i = 0; i < sizeof value; ++i)
            bytes.push_back(std::uint8_t(std::uint64_t(value) >> (8 * i)));
    }
    void put(double value) { put(std::bit_cast<std::uint64_t>(value)); }
    void put(float value) { put(std::bit_cast<std::uint32_t>(value)); }
    void put(const std::string& text) {
        count(text.size());
        bytes.insert(bytes.end(), text.begin(), text.end());
    }
    template <std::floating_point T> void put(const std::vector<T>& values) {
        static_assert(std::endian::native == std::endian::little); // else the words would have to be turned
        count(values.size());
        const auto part = std::as_bytes(std::span(values));
        const auto* const first = reinterpret_cast<const std::uint8_t*>(part.data());
        bytes.insert(bytes.end(), first, first + part.size());
    }
    void count(std::size_t n) { put(std::uint64_t(n)); }

    std::vector<std::uint8_t> bytes;
};

// Thrown on bytes that no writer left.
struct Malformed {
    std::string what;
};

class ByteReader {
  public:
    explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    template <std::unsigned_integral T> T get() {
        T value = 0;
        const auto part = take(sizeof(T));
        for (std::size_t i = 0; i < sizeof(T); ++i)
            value = T(value | T(part[i]) << (8 * i));
        return value;
    }
    double real() { return std::bit_cast<double>(get<std::uint64_t>()); }
    float single() { return std::bit_cast<float>(get<std::uint32_t>()); }
    // A number that a figure can be: finite and not negative.
    double figure(const char* what) {
        const double value = real();
        if (!std::isfinite(value) || value < 0)
            throw Malformed{std::string(what) + " is negative or not finite"};
        return value;
    }
    // How many things of at least `bytes` each follow: never more than what is left can hold.
    std::size_t count(std::size_t bytes) {
        const auto n = get<std::uint64_t>();
        if (n > bytes_.size() / bytes)
            throw Malformed{"it announces more than it holds"};
        return std::size_t(n);
    }
    std::string text() {
        const auto part = take(count(1));
        return {part.begin(), part.end()};
    }
    template <std::floating_point T> std::vector<T> reals() {
        std::vector<T> values(count(sizeof(T)));
        const auto part = take(values.size() * sizeof(T));
        if (!part.empty())
            std::memcpy(values.data(), part.data(), part.size());
        return values;
    }
    std::span<const std::uint8_t> take(std::size_t n) {
        if (n > bytes_.size())
            throw Malformed{"it announces more than it holds"};
        const auto part = bytes_.first(n);
        bytes_ = bytes_.subspan(n);
        return part;
    }
    bool atEnd() const { return bytes_.empty(); }
    void end() const {
        if (!atEnd())
            throw Malformed{"it holds more than it announces"};
    }

  private:
    std::span<const std::uint8_t> bytes_;
};

} // namespace cmpg
