// Writing EXR (float32, byte-deterministic) and PNG files.
#include "base/error.h"
#include "scene/image_decode.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfThreading.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stb/stb_image_write.h>
#include <thread>

namespace cmpg {
namespace {

class MemoryOutput : public Imf::OStream {
  public:
    MemoryOutput() : OStream("memory") {}
    void write(const char* data, int count) override {
        if (place_ + std::uint64_t(count) > bytes.size()) bytes.resize(place_ + std::uint64_t(count));
        std::memcpy(bytes.data() + place_, data, std::size_t(count));
        place_ += std::uint64_t(count);
    }
    std::uint64_t tellp() override { return place_; }
    void seekp(std::uint64_t place) override { place_ = place; }

    Bytes bytes;

  private:
    std::uint64_t place_ = 0;
};

struct Plane {
    std::string name;
    const float* first; // of the first pixel
    std::size_t step;   // floats from one pixel to the next
};

// What compresses a file, beside the caller. Its bytes are the same whatever their number.
int compressingThreads(int width, int height) {
    constexpr std::int64_t kFewPixels = 1 << 20; // not worth threads, which stay until the process ends
    if (std::int64_t(width) * height < kFewPixels) return 0;
    static const int threads = [] {
        const auto count = int(std::min(16u, std::thread::hardware_concurrency()));
        Imf::setGlobalThreadCount(std::max(count, Imf::globalThreadCount()));
        return count;
    }();
    return threads;
}

// Only the attributes every EXR file must have: no date, owner or program, so that equal pixels give equal bytes.
Bytes encodePlanes(int width, int height, const std::vector<Plane>& planes) {
    MemoryOutput stream;
    try {
        Imf::Header header(width, height);
        header.compression() = Imf::ZIP_COMPRESSION;
        Imf::FrameBuffer frame;
        for (const Plane& plane : planes) {
            header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
            const std::size_t step = plane.step * sizeof(float);
            // OpenEXR declares the base pointer mutable although it only reads.
            auto* base = reinterpret_cast<char*>(const_cast<float*>(plane.first));
            frame.insert(plane.name, Imf::Slice(Imf::FLOAT, base, step, step * std::size_t(width)));
        }
        Imf::OutputFile output(stream, header, compressingThreads(width, height));
        output.setFrameBuffer(frame);
        output.writePixels(height);
    } catch (const Iex::BaseExc& e) {
        const std::string size = std::to_string(width) + " x " + std::to_string(height);
        throw Error(ErrorKind::Output, "cannot encode an EXR of " + size + ": " + e.what());
    }
    return std::move(stream.bytes);
}

} // namespace

Bytes encodeExr(const Image& image) {
    const auto step = std::size_t(image.channels);
    std::vector<Plane> planes;
    for (std::size_t c = 0; c < 3; ++c) planes.push_back({std::string(1, "RGB"[c]), image.values.data() + (step == 1 ? 0 : c), step});
    return encodePlanes(image.width, image.height, planes);
}

void writeExr(const std::filesystem::path& file, const Image& image) { writeFile(file, encodeExr(image)); }

void writeExrLayers(const std::filesystem::path& file, const std::vector<std::pair<std::string, Image>>& layers) {
    if (layers.empty()) throw Error(ErrorKind::Output, "cannot write " + file.string() + ": it would have no layer");
    std::vector<Plane> planes;
    const Image& first = layers.front().second;
    for (const auto& [name, image] : layers) {
        if (image.channels != 1 || image.width != first.width || image.height != first.height)
            throw Error(ErrorKind::Output, "cannot write " + file.string() + ": layer " + name + " differs in size or channels");
        planes.push_back({name, image.values.data(), 1});
    }
    writeFile(file, encodePlanes(first.width, first.height, planes));
}

std::uint8_t pngCode(float linear) {
    const float clamped = linear > 0 ? std::min(linear, 1.0f) : 0.0f; // NaN becomes 0
    return std::uint8_t(std::lround(srgbEncode(clamped) * 255.0f));
}

Bytes encodePng(const Image& image) {
    Bytes pixels(image.pixels() * 3);
    for (std::size_t p = 0; p < image.pixels(); ++p)
        for (std::size_t c = 0; c < 3; ++c)
            pixels[p * 3 + c] = pngCode(image.values[p * std::size_t(image.channels) + (image.channels == 1 ? 0 : c)]);
    return encodePng(pixels, image.width, image.height, 3);
}

void writePng(const std::filesystem::path& file, const Image& image) { writeFile(file, encodePng(image)); }

Bytes encodePng(std::span<const std::uint8_t> pixels, int width, int height, int channels) {
    Bytes out;
    const auto append = [](void* context, void* data, int size) {
        const auto* first = static_cast<const std::uint8_t*>(data);
        static_cast<Bytes*>(context)->insert(static_cast<Bytes*>(context)->end(), first, first + size);
    };
    if (!stbi_write_png_to_func(append, &out, width, height, channels, pixels.data(), width * channels))
        throw Error(ErrorKind::Output, "cannot encode a PNG of " + std::to_string(width) + " x " + std::to_string(height));
    return out;
}

} // namespace cmpg
