// Seeds of pictures: OpenEXR of each compression, PNG, JPEG and Radiance.
#include "scene/image_decode.h"
#include "seeds.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>
#include <array>
#include <sstream>
#include <stb/stb_image_write.h>
#include <zlib.h>

namespace cmpg::fuzz {

std::string pngOf(int width, int height, int channels) {
    std::vector<std::uint8_t> texels(std::size_t(width) * height * channels);
    for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i] = std::uint8_t(60 + 37 * i);
    return textOf(encodePng(texels, width, height, channels));
}

namespace {

class TextOutput : public Imf::OStream {
  public:
    TextOutput() : OStream("memory") {}
    void write(const char* data, int count) override {
        text.resize(std::max(text.size(), place_ + std::size_t(count)));
        std::copy(data, data + count, text.begin() + std::ptrdiff_t(place_));
        place_ += std::size_t(count);
    }
    std::uint64_t tellp() override { return place_; }
    void seekp(std::uint64_t place) override { place_ = std::size_t(place); }
    std::string text;

  private:
    std::size_t place_ = 0;
};

constexpr int kExrWidth = 6, kExrHeight = 20; // so many lines that most compressions make more than one chunk

// The same picture in all channels.
class ExrChannels {
  public:
    ExrChannels() {
        for (std::size_t i = 0; i < halves_.size(); ++i)
            halves_[i] = floats_[i] = 0.01f * float(i % 17);
    }
    void add(Imf::Header& header, Imf::PixelType type, const std::vector<const char*>& names) {
        const bool half = type == Imf::HALF;
        char* const values = half ? reinterpret_cast<char*>(halves_.data()) : reinterpret_cast<char*>(floats_.data());
        const std::size_t bytes = half ? sizeof(Imath::half) : sizeof(float);
        for (const char* name : names) {
            header.channels().insert(name, Imf::Channel(type));
            frame.insert(name, Imf::Slice::Make(type, values, header.dataWindow(), bytes, bytes * kExrWidth));
        }
    }
    Imf::FrameBuffer frame;

  private:
    std::array<Imath::half, kExrWidth * kExrHeight> halves_;
    std::array<float, kExrWidth * kExrHeight> floats_;
};

struct ExrKind {
    Imf::Compression compression = Imf::ZIP_COMPRESSION;
    bool tiled = false, layer = false; // of floats, beside the picture
    std::vector<const char*> channels = {"R", "G", "B", "A"}; // in half floats, as B44 wants them
    Imath::V2i shift = {0, 0};                                // of what is stored against what is shown
};

std::string exr(const ExrKind& kind) {
    const Imath::V2i last(kExrWidth - 1, kExrHeight - 1);
    Imf::Header header({{0, 0}, last}, {kind.shift, last + kind.shift});
    header.compression() = kind.compression;
    if (kind.tiled)
        header.setTileDescription(Imf::TileDescription(4, 8, Imf::ONE_LEVEL));
    ExrChannels channels;
    channels.add(header, Imf::HALF, kind.channels);
    if (kind.layer)
        channels.add(header, Imf::FLOAT, {"normal.X", "normal.Y", "normal.Z"});
    TextOutput out;
    if (kind.tiled) {
        Imf::TiledOutputFile file(out, header, 1);
        file.setFrameBuffer(channels.frame);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
        Imf::OutputFile file(out, header, 1);
        file.setFrameBuffer(channels.frame);
        file.writePixels(kExrHeight);
    }
    return out.text;
}

// Two parts, of which readers take the first.
std::string exrOfParts() {
    std::vector<Imf::Header> headers(2, Imf::Header(kExrWidth, kExrHeight));
    std::vector<ExrChannels> channels(2);
    for (std::size_t i = 0; i < headers.size(); ++i) {
        headers[i].setName(i ? "second" : "first");
        headers[i].setType(Imf::SCANLINEIMAGE);
        channels[i].add(headers[i], Imf::HALF, {"R", "G", "B"});
    }
    TextOutput out;
    {
        Imf::MultiPartOutputFile file(out, headers.data(), int(headers.size()), false, 1);
        for (int i = 0; i < file.parts(); ++i) {
            Imf::OutputPart part(file, i);
            part.setFrameBuffer(channels[std::size_t(i)].frame);
            part.writePixels(kExrHeight);
        }
    }
    return out.text;
}

// A PNG of given kind with lines of zeros; palettes have two colours.
std::string png(std::uint32_t width, std::uint32_t height, char depth, char colour, bool interlaced) {
    const auto big = [](std::uint32_t v) { return std::string{char(v >> 24), char(v >> 16), char(v >> 8), char(v)}; };
    const auto chunk = [&](const std::string& kind, const std::string& data) {
        const std::string both = kind + data;
        return big(std::uint32_t(data.size())) + both + big(std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(both.data()), uInt(both.size()))));
    };
    const std::string lines(std::size_t(height) * (1 + std::size_t(width) * 8) * 2, '\0');
    std::string packed(200, '\0');
    uLongf size = packed.size();
    compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(lines.data()), lines.size(), 9);
    packed.resize(size);
    std::string out = "\x89PNG\r\n\x1a\n" + chunk("IHDR", big(width) + big(height) + depth + colour + std::string(2, '\0') + char(interlaced));
    if (colour == 3)
        out += chunk("PLTE", "\x10\x20\x30\xf0\xe0\xd0") + chunk("tRNS", "\x80");
    return out + chunk("IDAT", packed) + chunk("IEND", "");
}

std::string segment(char marker, const std::string& data) {
    const std::size_t size = data.size() + 2;
    return std::string{'\xff', marker, char(size >> 8), char(size)} + data;
}

// A baseline JPEG that a camera held upright.
std::string turnedJpeg(const std::string& jpeg) {
    const std::string tiff("MM\0\x2a\0\0\0\x08\0\1\x01\x12\0\3\0\0\0\1\0\6\0\0\0\0\0\0", 26);
    return jpeg.substr(0, 2) + segment('\xe1', std::string("Exif\0\0", 6) + tiff) + jpeg.substr(2);
}

// 8 x 8 grey in two scans: the average, then the rest.
std::string progressiveJpeg() {
    std::string quantisation(64, '\1');
    const std::string one(1, '\1'), zero(1, '\0');
    std::string lengths = one + std::string(15, '\0'); // a single code of one bit
    return "\xff\xd8" + segment('\xdb', zero + quantisation) + segment('\xc2', std::string("\x08\0\x08\0\x08\1\1\x11\0", 9)) +
           segment('\xc4', zero + lengths + zero) + segment('\xc4', "\x10" + lengths + zero) + segment('\xda', std::string("\1\1\0\0\0\0", 6)) + "\x7f" +
           segment('\xda', std::string("\1\1\0\1\x3f\0", 6)) + "\x7f" + "\xff\xd9";
}

} // namespace

void writeImages(const Folder& out) {
    const std::pair<const char*, Imf::Compression> compressions[] = {
        {"none", Imf::NO_COMPRESSION}, {"rle", Imf::RLE_COMPRESSION}, {"zips", Imf::ZIPS_COMPRESSION}, {"zip", Imf::ZIP_COMPRESSION},
        {"piz", Imf::PIZ_COMPRESSION}, {"pxr24", Imf::PXR24_COMPRESSION}, {"b44", Imf::B44_COMPRESSION}, {"b44a", Imf::B44A_COMPRESSION},
        {"dwaa", Imf::DWAA_COMPRESSION}, {"dwab", Imf::DWAB_COMPRESSION}};
    for (const auto& [name, compression] : compressions) {
        const bool floats = compression == Imf::PXR24_COMPRESSION || compression == Imf::DWAA_COMPRESSION; // which treat them in a way of their own
        out.write(std::string(name) + ".exr", exr({.compression = compression, .layer = floats}));
    }
    out.write("tiled.exr", exr({.tiled = true, .layer = true}));
    out.write("grey_alpha.exr", exr({.channels = {"Y", "A"}}));
    out.write("shifted.exr", exr({.shift = {2, -3}}));
    out.write("parts.exr", exrOfParts());
    out.write("rgb.png", pngOf(3, 2, 3));
    out.write("rgba.png", pngOf(2, 3, 4));
    out.write("grey_alpha.png", pngOf(2, 2, 2));
    out.write("palette.png", png(9, 2, 1, 3, false));
    out.write("deep.png", png(2, 2, 16, 6, false));
    out.write("interlaced.png", png(9, 9, 8, 2, true));
    std::ostringstream jpeg, hdr;
    const auto append = [](void* context, void* data, int size) { static_cast<std::ostringstream*>(context)->write(static_cast<const char*>(data), size); };
    std::vector<std::uint8_t> codes(17 * 9 * 3);
    std::vector<float> values(16 * 2 * 3);
    for (std::size_t i = 0; i < codes.size(); ++i)
        codes[i] = std::uint8_t(i * 5);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = 0.1f * float(i);
    stbi_write_jpg_to_func(append, &jpeg, 17, 9, 3, codes.data(), 60);
    stbi_write_hdr_to_func(append, &hdr, 16, 2, 3, values.data());
    out.write("baseline.jpg", jpeg.str());
    out.write("turned.jpg", turnedJpeg(jpeg.str()));
    out.write("progressive.jpg", progressiveJpeg());
    out.write("runs.hdr", hdr.str());
    out.write("flat.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + std::string("\x80\x40\x20\x81\x80\x40\x20\x00", 8));
}

} // namespace cmpg::fuzz
