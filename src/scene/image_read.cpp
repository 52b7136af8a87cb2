// Reading .exr, .hdr, .png and .jpg files: format by content, size limits before decoding.
#include "base/byte_stream.h"
#include "base/error.h"
#include "scene/image_decode.h"
#include "scene/image_fence.h"
#include "scene/jpeg_photo.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <stb/stb_image.h>

namespace cmpg {
namespace {

Error malformed(const std::string& name, const std::string& reason) {
    return {ErrorKind::Input, "cannot decode image " + name + ": " + reason, "the file is truncated, damaged or of another format",
            "re-export it as .exr, .hdr, .png or .jpg"};
}

void checkSize(std::uint64_t width, std::uint64_t height, std::uint64_t bytesPerPixel, const std::string& name, const ImageLimits& limits) {
    if (width == 0 || height == 0) throw malformed(name, "it has no pixels");
    if (width <= limits.maxEdge && height <= limits.maxEdge && width * height <= limits.maxPixels) return;
    const double mebibytes = double(width) * double(height) * double(bytesPerPixel) / (1024.0 * 1024.0);
    throw Error(ErrorKind::Input,
                "image " + name + " is too large: " + std::to_string(width) + " x " + std::to_string(height) + " would need " +
                    std::to_string(std::uint64_t(mebibytes)) + " MiB; at most " + std::to_string(limits.maxEdge) + " texels an edge and " +
                    std::to_string(limits.maxPixels) + " in all are read",
                "its resolution is too high, or its header is damaged", "scale it down");
}

void checkFinite(const RawImage& image, const std::string& name) {
    std::size_t bad = 0;
    for (const float v : image.values) bad += !std::isfinite(v);
    if (bad)
        throw Error(ErrorKind::Input, "image " + name + " has " + std::to_string(bad) + " values that are not finite (NaN or infinite)",
                    "the program that wrote it divided by zero, or went beyond the largest half float", "replace these values, and store it as 32-bit floats");
}

class MemoryInput : public Imf::IStream {
  public:
    MemoryInput(std::span<const std::uint8_t> bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}
    bool read(char* out, int count) override {
        if (count < 0 || place_ > bytes_.size() || bytes_.size() - place_ < std::size_t(count))
            throw Iex::InputExc("unexpected end of file");
        std::memcpy(out, bytes_.data() + place_, std::size_t(count));
        place_ += std::size_t(count);
        return place_ < bytes_.size();
    }
    std::uint64_t tellg() override { return place_; }
    void seekg(std::uint64_t place) override { place_ = place; }

  private:
    std::span<const std::uint8_t> bytes_;
    std::uint64_t place_ = 0;
};

// Names of the channels to read, in order: those of the layer where one is named; else R G B [A], else a single one (scalars are stored
// as Y by most programs).
std::vector<std::string> chooseChannels(const Imf::ChannelList& list, const std::string& name, const std::string& layer) {
    for (const std::array<const char*, 3>& set : {std::array{".R", ".G", ".B"}, std::array{".X", ".Y", ".Z"}})
        if (!layer.empty() && list.findChannel(layer + set[0]) && list.findChannel(layer + set[1]) && list.findChannel(layer + set[2]))
            return {layer + set[0], layer + set[1], layer + set[2]};
    for (const char* single : {".Y", ".Z", ""})
        if (!layer.empty() && list.findChannel(layer + single)) return {layer + single};
    if (layer.empty() && list.findChannel("R") && list.findChannel("G") && list.findChannel("B")) {
        std::vector<std::string> chosen{"R", "G", "B"};
        if (list.findChannel("A")) chosen.emplace_back("A");
        return chosen;
    }
    std::vector<std::string> all;
    for (auto i = list.begin(); i != list.end(); ++i) all.emplace_back(i.name());
    if (layer.empty() && all.size() == 1) return all;
    if (layer.empty() && all.size() == 2 && list.findChannel("Y") && list.findChannel("A")) return {"Y", "A"};
    std::string found;
    for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 12); ++i) found += " " + all[i];
    throw Error(ErrorKind::Input, name + (layer.empty() ? " has neither channels R, G, B nor a single one" : " has no layer '" + layer + "'"),
                "its channels are:" + (found.empty() ? " none" : found), "name one of its layers or store the image as R, G, B", {"layer"});
}

std::int64_t widthOf(const Imath::Box2i& window) { return std::int64_t(window.max.x) - window.min.x + 1; }
std::int64_t heightOf(const Imath::Box2i& window) { return std::int64_t(window.max.y) - window.min.y + 1; }

// The picture that is shown, of whose pixels the file holds those of `data`: renderers leave out an empty border, or store more than is shown. Pixels that
// are missing are black and have alpha 0, for which the others get one of 1 where there is none.
RawImage placed(const RawImage& image, const Imath::Box2i& data, const Imath::Box2i& shown) {
    const Imath::Box2i common({std::max(data.min.x, shown.min.x), std::max(data.min.y, shown.min.y)},
                              {std::min(data.max.x, shown.max.x), std::min(data.max.y, shown.max.y)});
    if (common.isEmpty()) throw Malformed{"its data window lies outside of its display window"};
    const std::uint32_t added = common != shown && !image.hasAlpha() ? 1 : 0;
    RawImage out{std::uint32_t(widthOf(shown)), std::uint32_t(heightOf(shown)), image.channels + added, {}, {}, true};
    out.values.resize(out.pixels() * out.channels);
    for (std::int64_t y = common.min.y; y <= common.max.y; ++y) {
        const float* from = image.values.data() + std::size_t((y - data.min.y) * widthOf(data) + common.min.x - data.min.x) * image.channels;
        float* to = out.values.data() + std::size_t((y - shown.min.y) * widthOf(shown) + common.min.x - shown.min.x) * out.channels;
        for (std::int64_t x = common.min.x; x <= common.max.x; ++x, from += image.channels, to += out.channels) {
            std::copy_n(from, image.channels, to);
            if (added) to[image.channels] = 1;
        }
    }
    return out;
}

RawImage decodeExr(std::span<const std::uint8_t> file, const std::string& name, const ImageLimits& limits) try {
    fenceExr(file);
    MemoryInput stream(file, name);
    // OpenEXR sizes its line table by the header, so it must refuse absurd headers itself.
    static const bool limited = [] {
        Imf::Header::setMaxImageSize(1 << 20, 1 << 20);
        Imf::Header::setMaxTileSize(1 << 13, 1 << 13);
        return true;
    }();
    (void)limited;
    Imf::InputFile input(stream, 1);
    const Imath::Box2i data = input.header().dataWindow(), shown = input.header().displayWindow();
    const std::vector<std::string> channels = chooseChannels(input.header().channels(), name, limits.layer);
    for (const Imath::Box2i& window : {data, shown}) {
        if (widthOf(window) <= 0 || heightOf(window) <= 0) throw malformed(name, "it has no pixels");
        checkSize(std::uint64_t(widthOf(window)), std::uint64_t(heightOf(window)), channels.size() * sizeof(float), name, limits);
    }

    RawImage image{std::uint32_t(widthOf(data)), std::uint32_t(heightOf(data)), std::uint32_t(channels.size()), {}, {}, true};
    image.values.resize(image.pixels() * channels.size());
    const std::size_t stride = channels.size() * sizeof(float);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < channels.size(); ++c)
        frame.insert(channels[c], Imf::Slice::Make(Imf::FLOAT, image.values.data() + c, data, stride, stride * image.width));
    input.setFrameBuffer(frame);
    input.readPixels(data.min.y, data.max.y);
    return data == shown ? image : placed(image, data, shown);
} catch (const Iex::BaseExc& e) {
    throw malformed(name, e.what());
}

struct StbFree {
    void operator()(void* p) const { stbi_image_free(p); }
};

RawImage decodeStb(std::span<const std::uint8_t> file, const std::string& name, const ImageLimits& limits) {
    if (file.size() > std::size_t(std::numeric_limits<int>::max())) throw malformed(name, "it is larger than 2 GiB");
    const auto* data = file.data();
    const int size = int(file.size());
    int w = 0, h = 0, c = 0;
    if (!stbi_info_from_memory(data, size, &w, &h, &c) || c < 1 || c > 4) throw malformed(name, stbi_failure_reason());
    const bool deep = stbi_is_16_bit_from_memory(data, size);
    checkSize(std::uint64_t(w), std::uint64_t(h), std::uint64_t(c) * (deep ? 4 : 1), name, limits);
    fenceStb(file, std::uint64_t(w), std::uint64_t(h));

    RawImage image;
    std::unique_ptr<void, StbFree> pixels;
    if (deep)
        pixels.reset(stbi_load_16_from_memory(data, size, &w, &h, &c, 0));
    else
        pixels.reset(stbi_load_from_memory(data, size, &w, &h, &c, 0));
    if (!pixels) throw malformed(name, stbi_failure_reason());
    image.width = std::uint32_t(w);
    image.height = std::uint32_t(h);
    image.channels = std::uint32_t(c);
    const std::size_t count = image.pixels() * image.channels;
    if (deep) {
        const auto* values = static_cast<const std::uint16_t*>(pixels.get());
        image.values.resize(count);
        for (std::size_t i = 0; i < count; ++i) image.values[i] = float(values[i]) / 65535.0f;
    } else {
        const auto* values = static_cast<const std::uint8_t*>(pixels.get());
        image.bytes.assign(values, values + count);
    }
    return image;
}

RawImage decodeRadiance(std::span<const std::uint8_t> file, const std::string& name, const ImageLimits& limits) try {
    return decodeHdr(file, [&](std::uint64_t width, std::uint64_t height) {
        checkSize(width, height, 3 * sizeof(float), name, limits);
        fenceHdr(file, width, height);
    });
} catch (const Error&) {
    throw;
} catch (const std::runtime_error& e) {
    throw malformed(name, e.what());
}

bool startsWith(std::span<const std::uint8_t> file, std::initializer_list<std::uint8_t> magic) {
    return file.size() >= magic.size() && std::equal(magic.begin(), magic.end(), file.begin());
}

} // namespace

RawImage decodeImage(std::span<const std::uint8_t> file, const std::string& name, const ImageLimits& limits) try {
    RawImage image;
    if (startsWith(file, {0x76, 0x2f, 0x31, 0x01}))
        image = decodeExr(file, name, limits);
    else if (startsWith(file, {'#', '?'}))
        image = decodeRadiance(file, name, limits);
    else if (startsWith(file, {0x89, 'P', 'N', 'G'}) || isJpeg(file))
        image = decodeStb(file, name, limits);
    else
        throw malformed(name, "its content is none of .exr, .hdr, .png, .jpg");
    if (limits.finite) checkFinite(image, name);
    return image;
} catch (const Malformed& e) {
    throw malformed(name, e.what);
}

float srgbDecode(float encoded) { // IEC 61966-2-1
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

float srgbEncode(float linear) {
    return linear <= 0.0031308f ? linear * 12.92f : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

const float* srgbTable() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (int i = 0; i < 256; ++i) t[std::size_t(i)] = srgbDecode(float(i) / 255.0f);
        return t;
    }();
    return table.data();
}

ReadImage readImage(const std::filesystem::path& file, const ReadOptions& options) {
    const Bytes content = readFile(file);
    const RawImage raw = decodeImage(content, file.string(), {std::size_t(1) << 20, options.maxPixels, options.layer, options.finite});
    const bool encoded = !raw.linear && !options.linear, eightBit = !raw.bytes.empty(), jpeg = isJpeg(content);
    const std::vector<std::uint8_t> compressed = jpeg ? clippedBeforeCompression(raw.bytes, raw.width, raw.height, raw.channels) : Bytes();
    const auto value = [&](std::size_t i) {
        if (eightBit) return encoded ? srgbTable()[raw.bytes[i]] : float(raw.bytes[i]) / 255.0f;
        return encoded ? srgbDecode(raw.values[i]) : raw.values[i];
    };
    ReadImage out;
    const std::uint32_t channels = raw.channels <= 2 ? 1 : 3;
    out.image = Image(int(raw.width), int(raw.height), int(channels));
    if (raw.hasAlpha()) out.alpha.resize(raw.pixels());
    if (!raw.linear) out.clipped.resize(out.image.values.size());
    for (std::size_t p = 0; p < raw.pixels(); ++p) {
        for (std::uint32_t c = 0; c < channels; ++c) {
            const std::size_t i = p * raw.channels + raw.channel(c);
            out.image.values[p * channels + c] = value(i);
            if (!raw.linear) out.clipped[p * channels + c] = jpeg ? compressed[i] : eightBit ? raw.bytes[i] == 255 : raw.values[i] >= 1;
        }
        if (!raw.hasAlpha()) continue;
        const std::size_t i = p * raw.channels + raw.channel(3);
        out.alpha[p] = eightBit ? float(raw.bytes[i]) / 255.0f : raw.values[i]; // alpha is never sRGB-encoded
    }
    return jpeg ? upright(std::move(out), exifOrientation(content)) : out;
}

} // namespace cmpg
