// Writes the seeds of the fuzz targets: small files that together have every feature their readers know. Those of meshes and of Mitsuba's scenes are text, and
// written by hand.
//   make_seeds tests/fuzz/corpus
#include "guiding/guide_file.h"
#include "optimize/checkpoint.h"
#include "optimize/learned.h"
#include "optimize/linear_model.h"
#include "scene/image_decode.h"
#include "support/scene_mutation.h"
#include "vk/kernel_file.h"

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
#include <cstdio>
#include <sstream>
#include <stb/stb_image_write.h>
#include <zlib.h>

using namespace cmpg;
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

// Compiler-independent bytes of numbers.
template <class T> std::string bytesOf(const std::vector<T>& values) { return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)}; }
std::string textOf(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

struct Folder {
    fs::path path;
    void write(const std::string& name, const std::string& content) const {
        writeFile(path / name, {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
    }
};

// ---- scenes

std::string dataUri(const std::string& bytes) { return "data:application/octet-stream;base64," + test::toBase64(bytes); }

// A glTF whose accessors and images have a buffer each, embedded.
struct SceneSeed {
    Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", Json::array()}}}}};

    std::size_t view(const std::string& bytes) {
        json["buffers"].push_back({{"byteLength", bytes.size()}, {"uri", dataUri(bytes)}});
        json["bufferViews"].push_back({{"buffer", json["buffers"].size() - 1}, {"byteLength", bytes.size()}});
        return json["bufferViews"].size() - 1;
    }
    template <class T> std::size_t accessor(const std::vector<T>& values, int componentType, const char* type, std::size_t components, bool normalized = false) {
        json["accessors"].push_back(
            {{"bufferView", view(bytesOf(values))}, {"componentType", componentType}, {"count", values.size() / components}, {"type", type}, {"normalized", normalized}});
        return json["accessors"].size() - 1;
    }
    std::size_t vec3(const std::vector<float>& v) { return accessor(v, 5126, "VEC3", 3); }
    std::size_t vec2(const std::vector<float>& v) { return accessor(v, 5126, "VEC2", 2); }
    std::size_t indices(const std::vector<std::uint16_t>& v) { return accessor(v, 5123, "SCALAR", 1); }
    std::size_t texture(const std::string& image) {
        json["images"].push_back({{"uri", dataUri(image)}});
        json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
        json["textures"].push_back({{"source", json["images"].size() - 1}, {"sampler", 0}});
        return json["textures"].size() - 1;
    }
    void node(Json node) {
        json["nodes"].push_back(std::move(node));
        json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
    }
    // A quad in the plane z, facing +z, of a material; further attributes are added to the primitive returned.
    Json& quad(float z, int material) {
        Json primitive = {{"attributes", {{"POSITION", vec3({-1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z})}, {"TEXCOORD_0", vec2({0, 1, 1, 1, 1, 0, 0, 0})}}},
                          {"indices", indices({0, 1, 2, 0, 2, 3})}};
        if (material >= 0)
            primitive["material"] = material;
        json["meshes"].push_back({{"primitives", {primitive}}});
        node({{"mesh", json["meshes"].size() - 1}});
        return json["meshes"].back()["primitives"][0];
    }
    void camera() {
        json["cameras"].push_back({{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"aspectRatio", 1.5}, {"znear", 0.1}}}});
        node({{"camera", json["cameras"].size() - 1}, {"name", "eye"}, {"translation", {0, 0, 3}}});
    }
    std::string text() const { return json.dump(); }
};

std::string pngOf(int width, int height, int channels) {
    std::vector<std::uint8_t> texels(std::size_t(width) * height * channels);
    for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i] = std::uint8_t(60 + 37 * i);
    return textOf(encodePng(texels, width, height, channels));
}

// Every slot textured, masks, normal maps with tangents, second coordinates, vertex colours, transforms.
SceneSeed texturedScene() {
    SceneSeed s;
    const std::size_t rgba = s.texture(pngOf(4, 2, 4)), rgb = s.texture(pngOf(2, 2, 3)), grey = s.texture(textOf(encodeExr(Image(2, 1, 1, 0.5f))));
    const Json transform = {{"KHR_texture_transform", {{"offset", {0.1, 0.2}}, {"scale", {2, 3}}, {"rotation", 0.5}, {"texCoord", 1}}}};
    s.json["materials"] = {
        {{"name", "all"},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.4},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.8, 0.7, 0.6, 0.9}},
           {"roughnessFactor", 0.5},
           {"metallicFactor", 0.3},
           {"baseColorTexture", {{"index", rgba}, {"extensions", transform}}},
           {"metallicRoughnessTexture", {{"index", rgb}, {"texCoord", 1}}}}},
         {"normalTexture", {{"index", rgb}, {"scale", 0.7}}},
         {"occlusionTexture", {{"index", rgb}}},
         {"emissiveTexture", {{"index", grey}}},
         {"emissiveFactor", {1, 0.5, 0.2}},
         {"extensions",
          {{"KHR_materials_specular", {{"specularFactor", 0.7}, {"specularTexture", {{"index", rgba}}}, {"specularColorFactor", {1, 0.9, 0.8}}}},
           {"KHR_materials_ior", {{"ior", 1.4}}},
           {"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}}}}},
        {{"name", "plain"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}}}}};
    Json& attributes = s.quad(0, 0)["attributes"];
    attributes["NORMAL"] = s.vec3({0, 0, 1, 0, 0, 1, 0, 0.1f, 1, 0, 0, 1});
    attributes["TANGENT"] = s.accessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1}, 5126, "VEC4", 4);
    attributes["TEXCOORD_1"] = s.accessor<std::uint16_t>({0, 0, 65535, 0, 65535, 65535, 0, 65535}, 5123, "VEC2", 2, true);
    attributes["COLOR_0"] = s.accessor<std::uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255}, 5121, "VEC4", 4, true);
    s.quad(-1, 1);
    s.json["extensionsUsed"] = {"KHR_materials_specular", "KHR_materials_ior", "KHR_materials_emissive_strength", "KHR_texture_transform"};
    s.json["images"][0]["extras"] = {{"colorSpace", "linear"}};
    s.camera();
    return s;
}

// Clear coats, anisotropy, sheen, glass with an absorbing volume, a pane, partial coverage.
SceneSeed layeredScene() {
    SceneSeed s;
    const std::size_t rgba = s.texture(pngOf(4, 2, 4)), rgb = s.texture(pngOf(2, 2, 3));
    const Json smooth = {{"roughnessFactor", 0.2}, {"metallicFactor", 0}};
    s.json["materials"] = {
        {{"name", "varnish"},
         {"pbrMetallicRoughness", {{"metallicFactor", 0.5}}},
         {"extensions",
          {{"KHR_materials_clearcoat",
            {{"clearcoatFactor", 0.7},
             {"clearcoatTexture", {{"index", rgb}}},
             {"clearcoatRoughnessFactor", 0.4},
             {"clearcoatRoughnessTexture", {{"index", rgb}}},
             {"clearcoatNormalTexture", {{"index", rgb}, {"scale", 0.5}}}}},
           {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.6}, {"anisotropyRotation", 0.3}, {"anisotropyTexture", {{"index", rgb}}}}},
           {"KHR_materials_sheen",
            {{"sheenColorFactor", {0.9, 0.5, 0.1}},
             {"sheenColorTexture", {{"index", rgba}}},
             {"sheenRoughnessFactor", 0.4},
             {"sheenRoughnessTexture", {{"index", rgba}}}}}}}},
        {{"name", "ink"},
         {"pbrMetallicRoughness", smooth},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
           {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 0.5}, {"attenuationColor", {0.9, 0.5, 0.1}}}},
           {"KHR_materials_ior", {{"ior", 1.33}}}}}},
        {{"name", "pane"}, {"pbrMetallicRoughness", smooth}, {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}}}}},
        {{"name", "leaf"},
         {"alphaMode", "BLEND"},
         {"emissiveFactor", {1, 1, 1}},
         {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.8}}, {"baseColorTexture", {{"index", rgba}}}}}}};
    for (int material = 0; material < 4; ++material)
        s.quad(float(-material), material);
    s.json["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_anisotropy", "KHR_materials_sheen", "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"};
    s.camera();
    return s;
}

// Lights and cameras of all kinds, an environment, a hierarchy of nodes.
SceneSeed litScene() {
    SceneSeed s;
    s.json["materials"] = {{{"name", "floor"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"metallicFactor", 0.1}}}},
                           {{"name", "lamp"}, {"emissiveFactor", {1, 1, 1}}, {"alphaMode", "BLEND"}}};
    s.quad(0, 0);
    s.quad(4, 1);
    s.quad(-2, -1);
    s.json["nodes"][1]["rotation"] = {1, 0, 0, 0};
    s.json["nodes"][2]["matrix"] = {-1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0.5, 1};
    s.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"intensity", 20}, {"color", {1, 0.5, 0.5}}, {"range", 10}},
        {{"type", "spot"}, {"intensity", 30}, {"spot", {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.6}}}},
        {{"type", "directional"}, {"intensity", 2}}};
    for (int light = 0; light < 3; ++light)
        s.json["nodes"].push_back({{"translation", {light - 1, 0.5, 2}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    s.node({{"children", {3, 4, 5}}, {"scale", {1, 1, 2}}});
    s.camera();
    s.json["cameras"].push_back({{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"znear", 0}, {"zfar", 9}}}});
    s.node({{"camera", 1}, {"translation", {0, 0, 3}}});
    s.json["scenes"][0]["extras"] = {{"maxDepth", 4}, {"environment", {{"uri", "sky.exr"}, {"intensity", 2}, {"rotation", 0.3}}}};
    s.json["scenes"][0]["extras"]["environment"]["uri"] = dataUri(textOf(encodeExr(Image(4, 2, 3, 0.25f))));
    return s;
}

// Accessors of all kinds: sparse, quantised, strided, without data, strips and fans, files beside the scene.
SceneSeed packedScene() {
    SceneSeed s;
    s.json["materials"] = {{{"name", "a"}, {"emissiveFactor", {1, 1, 1}}}};
    Json& strip = s.quad(0, 0);
    strip["mode"] = 5;
    const std::size_t where = s.view(bytesOf<std::uint8_t>({2, 0})), what = s.view(bytesOf<float>({1, 2, 0.5f}));
    s.json["accessors"][strip["attributes"]["POSITION"].get<std::size_t>()]["sparse"] = {
        {"count", 1}, {"indices", {{"bufferView", where}, {"componentType", 5121}}}, {"values", {{"bufferView", what}}}};
    Json& fan = s.quad(1, 0);
    fan["mode"] = 6;
    fan["attributes"]["POSITION"] = s.accessor<std::int8_t>({-127, -127, 0, 0, 127, -127, 0, 0, 127, 127, 0, 0, -127, 127, 0, 0}, 5120, "VEC3", 4, true);
    s.json["bufferViews"].back()["byteStride"] = 4;
    s.json["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
    fan["attributes"]["NORMAL"] = s.json["accessors"].size() - 1;
    Json& points = s.quad(2, 0);
    points["mode"] = 0;
    s.json["buffers"].push_back({{"uri", "data.bin"}, {"byteLength", 36}});
    s.json["bufferViews"].push_back({{"buffer", s.json["buffers"].size() - 1}, {"byteLength", 36}});
    s.json["accessors"].push_back({{"bufferView", s.json["bufferViews"].size() - 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
    s.quad(3, 0)["attributes"] = {{"POSITION", s.json["accessors"].size() - 1}};
    s.json["meshes"].back()["primitives"][0].erase("indices");
    s.json["images"] = {{{"uri", "image.png"}}};
    s.json["textures"] = {{{"source", 0}}};
    s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    s.json["extensionsUsed"] = s.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    s.json["skins"] = {{{"joints", {0}}}};
    s.json["animations"] = {{{"channels", Json::array()}}};
    return s;
}

std::string word(std::size_t value) { return bytesOf<std::uint32_t>({std::uint32_t(value)}); }

// A triangle and an image in the binary chunk.
std::string binaryScene() {
    std::string binary = bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const std::string png = pngOf(2, 2, 3);
    const std::size_t imageBytes = png.size();
    binary += png;
    binary.resize((binary.size() + 3) / 4 * 4);
    const Json json = {{"asset", {{"version", "2.0"}}},
                       {"scenes", {{{"nodes", {0}}}}},
                       {"nodes", {{{"mesh", 0}}}},
                       {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"material", 0}}}}}}},
                       {"materials", {{{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}}}},
                       {"textures", {{{"source", 0}}}},
                       {"images", {{{"bufferView", 1}, {"mimeType", "image/png"}}}},
                       {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}}},
                       {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}, {{"buffer", 0}, {"byteOffset", 36}, {"byteLength", imageBytes}}}},
                       {"buffers", {{{"byteLength", binary.size()}}}}};
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return "glTF" + word(2) + word(12 + 8 + text.size() + 8 + binary.size()) + word(text.size()) + "JSON" + text + word(binary.size()) + std::string("BIN\0", 4) + binary;
}

void writeScenes(const Folder& out) {
    out.write("textured.gltf", texturedScene().text());
    out.write("layered.gltf", layeredScene().text());
    out.write("lit.gltf", litScene().text());
    out.write("packed.gltf", packedScene().text());
    out.write("binary.glb", binaryScene());
}

// ---- images

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

// ---- guides and checkpoints

SdTree learnedTree() {
    SdTreeConfig config;
    config.cellRecords = 10;
    config.maxNodes = 40;
    SdTree tree(glm::vec3(-1), glm::vec3(1, 2, 3), config);
    std::vector<CellRecords> records;
    for (std::uint32_t cell = 0; cell < tree.cells().size(); ++cell) {
        CellRecords r{cell, 20 + cell, 3, 1, {}};
        for (const QuadNode& node : tree.cells()[cell].nodes)
            r.leaves.push_back({{{1, 0.5, 0}, {double(cell), 0, 0}, {0, 0, 2}, {node.child[0] ? 0.0 : 7.0, 1, 1}}});
        records.push_back(std::move(r));
    }
    tree.update(records);
    return tree;
}

void writeGuides(const Folder& out) {
    GuideContext context;
    context.geometry = 0x1234;
    context.parameters = {"wall.baseColor", "lamp.emission"};
    context.figures[Sampling::Bsdf] = {0.5, 3, 2};
    context.figures[Sampling::Conditional] = {0.25, 4, 2};
    context.rouletteFigures[Sampling::Conditional] = {0.2, 5, 1};
    context.imageFigures[Sampling::Primal] = {0.1, 3, 4};
    context.reference = 0.75;
    saveGuide(out.path / "learned.guide", learnedTree(), context);
    SdTreeConfig small;
    small.maxNodes = 1;
    saveGuide(out.path / "empty.guide", SdTree(glm::vec3(0), glm::vec3(1), small), {});
}

void writeCheckpoints(const Folder& out) {
    for (const EnumName<OptimizerKind>& optimizer : kOptimizers) {
        OptimizeConfig config;
        config.steps = 20;
        config.optimizer.kind = optimizer.value;
        config.targets = test::makeTargets(1, 2, 2);
        Scene scene = test::makeScene();
        test::LinearModel model(scene, 1, 2, 2, 0.1);
        Optimization run(model, scene, config, {0, 1});
        run.step();
        run.step();
        const std::string name = optimizer.name, text = R"({"command": "optimize", "steps": 20, "optimizer": ")" + name + "\"}";
        std::vector<FileSection> sections = checkpointSections(run, model, {{"--loss", "\"mse\""}, {"scene", "0"}}, text, "a device");
        if (optimizer.value == OptimizerKind::Auto) {
            ByteWriter learned;
            const GuidedState state{.images = {{{0.5, 3, 2}, {0.25, 4, 1}}, {0.5, 0}, 1, 3, 2}, .derivatives = {{{0.5, 3, 2}}, {0.9}, 0, 1, 0},
                                    .exploration = {.noise = 0.5, .watched = 2, .urgent = true, .spent = 100, .trials = 50}, .reference = 0.5, .trained = true, .step = 2};
            const SdTree tree = learnedTree();
            putLearned(learned, state, &tree);
            sections.back().bytes = std::move(learned.bytes);
        }
        out.write(name + ".bin", textOf(joinSections(sections)));
    }
}

// ---- kernels

void writeKernels(const Folder& out) {
    // A header, a capability, a memory model; the same with many names, which compress well.
    std::vector<std::uint32_t> words = {0x07230203, 0x00010500, 0, 1, 0, 2u << 16 | 17, 1, 3u << 16 | 14, 0, 1};
    const auto write = [&](const char* name) { out.write(name, textOf(encodeKernel("a kernel", words))); };
    write("small.spirv");
    out.write("code.words", bytesOf(words));
    for (int i = 0; i < 500; ++i)
        words.insert(words.end(), {3u << 16 | 5, 1, 0x61});
    write("names.spirv");
}

// ---- command lines

void writeOptions(const Folder& out) {
    out.write("render.txt", "--headless\nrender\nroom.gltf\n-o\nimage.exr\n--spp\n256\n--sampling\nprimal\n--train\n4\n--set\na.baseColor=0.5,0.5,0.5\n");
    out.write("gradient.txt", "gradient\nroom.gltf\n--param\npainting.*\n--target\nref.exr\n-o\ng.exr\n--error-target\n1%\n--loss=smape\n--positivize\n");
    out.write("optimize.txt", "optimize\nroom.gltf\n--param\na.baseColor\n--target\ncam=ref.exr\n-o\nrun\n--rate\nbaseColor=0.1\n--schedule\ncosine\n"
                              "--checkpoint-every\n10m\n--time-budget\n5min\n");
    out.write("compare.txt", "compare\nroom.gltf\n--param\na.baseColor\n--methods\nplain,conditional+roulette,ours+nonee\n--time\n20\n-o\nout\n--mode\nreverse,forward\n");
    out.write("tradeoff.txt", "tradeoff\nroom.gltf\n--param\na.baseColor\n-o\nout\n--seeds\n4\n--quality\npreview\n");
    out.write("view.txt", "view\nimage.exr\n-o\na.png\n--signed\n--exposure\n-1.5\n--layer\nnormal\n");
    out.write("guide.txt", "guide\na.guide\n--weights\n1,2\n--cell\n3\n--csv\n");
    out.write("help.txt", "render\n--help\n");
    out.write("open.txt", "room.gltf\n--display-server\n[::1]:14158\n--device\nllvm\n");
    out.write("config.txt", "--config\nrun.json\n--spp\n9\n-o\nrun\n\n"
                            R"({"command":"optimize","input":"room.gltf","param":["a.baseColor"],"target":["ref.exr"],"steps":10,"rate":["0.1"],"error-target":0.01,)"
                            R"("sampler":"sobol","roulette":"adjoint","seed":7,"guide-share":0.5,"set":["a=1"],"made-with":{"device":"x"}})");
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "make_seeds FOLDER\n");
        return 2;
    }
    const fs::path root = argv[1];
    writeScenes({root / "scene"});
    writeImages({root / "image"});
    writeGuides({root / "guide"});
    writeCheckpoints({root / "checkpoint"});
    writeKernels({root / "kernel"});
    writeOptions({root / "options"});
}
