// Packets of the display protocol: bytes only, no network.
#include "imaging/display_packets.h"

#include <bit>
#include <cstring>

namespace cmpg {
namespace {

static_assert(std::endian::native == std::endian::little, "the protocol is little-endian, and numbers are sent as they lie in memory");

enum class Type : std::uint8_t { Create = 4, Update = 6 };

class Writer {
  public:
    explicit Writer(Type type) {
        number(std::uint32_t(0)); // the length, known at the end
        number(std::uint8_t(type));
        number(std::uint8_t(0)); // the display need not bring it to the front
    }
    template <class Number> void number(Number value) { bytes(&value, sizeof value); }
    void text(const std::string& s) { bytes(s.c_str(), s.size() + 1); }
    void channels(const Image& image) {
        number(std::int32_t(image.channels));
        if (image.channels == 1)
            return text("Y");
        for (int c = 0; c < image.channels; ++c)
            text(std::string(1, "RGBA"[c]));
    }
    void bytes(const void* from, std::size_t count) {
        const std::size_t at = packet_.size();
        packet_.resize(at + count);
        std::memcpy(packet_.data() + at, from, count);
    }
    Packet finish() {
        const auto length = std::uint32_t(packet_.size());
        std::memcpy(packet_.data(), &length, sizeof length);
        return std::move(packet_);
    }

  private:
    Packet packet_;
};

} // namespace

Packet createPacket(const std::string& name, const Image& image) {
    Writer w(Type::Create);
    w.text(name);
    w.number(std::int32_t(image.width));
    w.number(std::int32_t(image.height));
    w.channels(image);
    return w.finish();
}

Packet updatePacket(const std::string& name, const Image& image, int first, int rows) {
    Writer w(Type::Update);
    w.text(name);
    w.channels(image);
    for (const int v : {0, first, image.width, rows})
        w.number(std::int32_t(v));
    for (int c = 0; c < image.channels; ++c)
        w.number(std::int64_t(c)); // where the channel begins, in floats
    for (int c = 0; c < image.channels; ++c)
        w.number(std::int64_t(image.channels)); // from pixel to pixel
    w.bytes(image.at(0, first), std::size_t(rows) * image.width * image.channels * sizeof(float));
    return w.finish();
}

} // namespace cmpg
