// Reading Radiance .hdr pictures. (libstb loops for ever on some truncated ones.)
#include "scene/image_decode.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace cmpg {
namespace {

// Byte by byte; reading past the end is an error.
class Reader {
  public:
    explicit Reader(std::span<const std::uint8_t> file) : file_(file) {}
    std::uint8_t byte() {
        if (place_ >= file_.size()) throw std::runtime_error("unexpected end of file");
        return file_[place_++];
    }
    std::string line() {
        std::string text;
        for (char c = char(byte()); c != '\n'; c = char(byte())) text += c;
        return text;
    }
    bool startsRun() const { // of a run-length encoded row: 2, 2, then the width in 15 bits
        return file_.size() - place_ >= 4 && file_[place_] == 2 && file_[place_ + 1] == 2 && file_[place_ + 2] < 128;
    }

  private:
    std::span<const std::uint8_t> file_;
    std::size_t place_ = 0;
};

// The four channels one after the other, each as runs (more than 128: so many times the next byte) and literal bytes.
void readEncodedRow(Reader& in, std::uint32_t width, Bytes& rgbe) {
    in.byte();
    in.byte();
    const std::uint32_t high = in.byte(), low = in.byte();
    if (high * 256 + low != width) throw std::runtime_error("a row has another width than the header says");
    for (std::uint32_t c = 0; c < 4; ++c)
        for (std::uint32_t x = 0; x < width;) {
            std::uint32_t count = in.byte();
            const bool run = count > 128;
            if (run) count -= 128;
            if (count == 0 || count > width - x) throw std::runtime_error("a run reaches beyond its row");
            const std::uint8_t repeated = run ? in.byte() : 0;
            for (std::uint32_t i = 0; i < count; ++i, ++x) rgbe[std::size_t(x) * 4 + c] = run ? repeated : in.byte();
        }
}

} // namespace

RawImage decodeHdr(std::span<const std::uint8_t> file, const std::function<void(std::uint64_t, std::uint64_t)>& checkSize) {
    Reader in(file);
    bool rgb = false;
    for (std::string line = in.line(); !line.empty(); line = in.line()) rgb |= line == "FORMAT=32-bit_rle_rgbe";
    if (!rgb) throw std::runtime_error("its format is not 32-bit_rle_rgbe");
    unsigned width = 0, height = 0;
    const std::string resolution = in.line();
    if (resolution.size() > 40 || std::sscanf(resolution.c_str(), "-Y %9u +X %9u", &height, &width) != 2)
        throw std::runtime_error("its resolution line is not of the form \"-Y height +X width\"");
    checkSize(width, height);

    RawImage image{width, height, 3, {}, {}, true};
    image.values.resize(image.pixels() * 3);
    Bytes rgbe(std::size_t(width) * 4);
    for (std::uint32_t y = 0; y < height; ++y) {
        if (width >= 8 && width < 32768 && in.startsRun())
            readEncodedRow(in, width, rgbe);
        else
            for (std::uint8_t& b : rgbe) b = in.byte();
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::uint8_t* texel = &rgbe[std::size_t(x) * 4];
            // A shared exponent, biased by 128, of 8-bit mantissas.
            const float scale = texel[3] ? std::ldexp(1.0f, int(texel[3]) - 136) : 0.0f;
            for (std::size_t c = 0; c < 3; ++c) image.values[(std::size_t(y) * width + x) * 3 + c] = float(texel[c]) * scale;
        }
    }
    return image;
}

} // namespace cmpg
