// A glTF file and the files it names, read safely: nothing outside its folder, nothing larger than the file says.
#include "scene/gltf/document.h"

#include "base/error.h"
#include "scene/contained_path.h"
#include "scene/gltf/fence.h"
#include "scene/gltf/lobe_slots.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t kGlbMagic = 0x46546c67, kGlbJson = 0x4e4f534a, kGlbBinary = 0x004e4942;
// Deeper nesting than any real file has; bounds the recursion when the JSON is written again.
constexpr int kMaxJsonDepth = 64;

constexpr const char* kKnownExtensions[] = {
    "KHR_materials_specular", "KHR_materials_ior",   "KHR_materials_emissive_strength",
    "KHR_materials_transmission", "KHR_materials_volume", "KHR_texture_transform",  "KHR_lights_punctual", "KHR_mesh_quantization",
};

std::uint32_t littleEndian(const Bytes& bytes, std::size_t at) {
    return std::uint32_t(bytes[at]) | std::uint32_t(bytes[at + 1]) << 8 | std::uint32_t(bytes[at + 2]) << 16 |
           std::uint32_t(bytes[at + 3]) << 24;
}

int hexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

// How many brackets are open at once, outside strings. (The parser's own callback costs quadratic time on long arrays.)
int nestingDepth(const char* first, const char* last) {
    int depth = 0, deepest = 0;
    bool inString = false;
    for (const char* c = first; c < last; ++c) {
        if (inString && *c == '\\') {
            ++c;
        } else if (*c == '"') {
            inString = !inString;
        } else if (!inString) {
            depth += (*c == '[' || *c == '{') - (*c == ']' || *c == '}');
            deepest = std::max(deepest, depth);
        }
    }
    return deepest;
}

std::string percentDecode(const JsonView& uri) {
    const std::string text = uri.string();
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            out += text[i];
            continue;
        }
        const int high = i + 2 < text.size() ? hexDigit(text[i + 1]) : -1, low = high < 0 ? -1 : hexDigit(text[i + 2]);
        if (low < 0) uri.fail("is not a valid URI: % is not followed by two hexadecimal digits");
        out += char(high * 16 + low);
        i += 2;
    }
    if (out.find('\0') != std::string::npos) uri.fail("is not a valid URI: it contains a zero byte");
    return out;
}

Bytes decodeBase64(const JsonView& uri, std::string text) {
    while (!text.empty() && text.back() == '=') text.pop_back();
    Bytes out;
    std::string mediaType;
    // It stops without a word where the text is no longer base64; the length tells.
    if (!tinygltf::DecodeDataURI(&out, mediaType, "data:application/octet-stream;base64," + text, text.size() * 6 / 8, true))
        uri.fail("holds data that is not base64");
    return out;
}

} // namespace

bool isDataUri(const std::string& uri) { return uri.rfind("data:", 0) == 0; }

bool supportsExtension(const std::string& name) {
    return std::find(std::begin(kKnownExtensions), std::end(kKnownExtensions), name) != std::end(kKnownExtensions) ||
           std::any_of(kGltfLobeSlots.begin(), kGltfLobeSlots.end(), [&](const GltfLobeSlot& slot) { return name == slot.extension; });
}

GltfDocument::GltfDocument(const fs::path& file) : name_(file.string()) {
    const Bytes bytes = readFile(file);
    // A link to a scene stands for the scene itself: its neighbours are where it really lies.
    file_ = fs::canonical(file);
    folder_ = file_.parent_path();
    if (bytes.size() >= 4 && littleEndian(bytes, 0) == kGlbMagic)
        parseBinary(bytes);
    else
        parseJson(reinterpret_cast<const char*>(bytes.data()), reinterpret_cast<const char*>(bytes.data()) + bytes.size());
    checkVersionAndExtensions();
    readBuffers();
    checkGltf(root());
    buildModel();
}

void GltfDocument::parseBinary(const Bytes& file) {
    const auto fail = [&](const std::string& what) {
        throw Error(ErrorKind::Input, name_ + ": " + what, "the file is truncated or damaged", "copy or export it again");
    };
    if (file.size() < 20) fail("the .glb header is incomplete");
    if (littleEndian(file, 4) != 2) fail("the .glb container has version " + std::to_string(littleEndian(file, 4)) + "; only 2 is read");
    const std::uint64_t length = littleEndian(file, 8);
    if (length > file.size())
        fail("the file has " + std::to_string(file.size()) + " bytes, but its header says " + std::to_string(length));
    bool hasJson = false;
    for (std::uint64_t at = 12; at + 8 <= length;) {
        const std::uint64_t size = littleEndian(file, at), type = littleEndian(file, at + 4);
        at += 8;
        if (size > length - at) fail("a chunk of the .glb reaches beyond its end");
        if (!hasJson && type != kGlbJson) fail("the first chunk of the .glb is not JSON");
        const std::uint8_t* first = file.data() + at;
        if (type == kGlbJson && !hasJson) {
            parseJson(reinterpret_cast<const char*>(first), reinterpret_cast<const char*>(first) + size);
            hasJson = true;
        } else if (type == kGlbBinary && !hasBinaryChunk_) {
            binaryChunk_.assign(first, first + size);
            hasBinaryChunk_ = true;
        }
        at += size;
    }
    if (!hasJson) fail("the .glb has no JSON chunk");
}

void GltfDocument::parseJson(const char* first, const char* last) {
    const char* const remedy = "export the scene as glTF 2.0 (.gltf or .glb)";
    if (nestingDepth(first, last) > kMaxJsonDepth)
        throw Error(ErrorKind::Input, name_ + ": the JSON is nested too deeply", "the file is damaged", remedy);
    try {
        json_ = Json::parse(first, last);
    } catch (const Json::exception& e) {
        throw Error(ErrorKind::Input, name_ + ": this is not valid JSON: " + e.what(), "the file is truncated, damaged, or not a glTF file",
                    remedy);
    }
    if (!json_.is_object()) throw Error(ErrorKind::Input, name_ + ": the JSON is not an object", "it is not a glTF file", remedy);
}

void GltfDocument::checkVersionAndExtensions() const {
    const JsonView asset = root()["asset"];
    const std::string version = asset["version"].string();
    if (version.rfind("2.", 0) != 0)
        asset["version"].fail("is " + version + "; only glTF 2 is read", "an old exporter", "convert the scene to glTF 2.0");
    const JsonView required = root()["extensionsRequired"];
    for (std::uint32_t i = 0; i < required.size(); ++i) {
        const std::string extension = required.at(i).string();
        if (!supportsExtension(extension))
            required.at(i).fail("is " + extension + ", which is not supported", "the scene cannot be read without this extension",
                                "export it without " + extension);
    }
}

fs::path GltfDocument::resolve(const JsonView& uri) const {
    const std::string relative = percentDecode(uri);
    // In the URI as it stands: a name may have %3A for a colon of its own.
    const std::string text = uri.string();
    if (const std::size_t colon = text.find(':'); colon != std::string::npos && text.find('/') > colon)
        uri.fail("is \"" + relative + "\", which is not a relative path", "scenes may only name files inside their own folder",
                 "put the file next to the scene and name it by a relative path, with %3A for a colon in its name");
    const ContainedPath path = containedPath(folder_, relative);
    if (!path.refusal.empty())
        uri.fail("is \"" + relative + "\", " + path.refusal, path.cause, path.remedy);
    return path.file;
}

std::vector<fs::path> GltfDocument::files() const {
    std::vector<fs::path> files{file_};
    const auto add = [&](const JsonView& holder) {
        const JsonView uri = holder["uri"];
        if (!uri.exists() || isDataUri(uri.string())) return;
        try {
            files.push_back(resolve(uri));
        } catch (const Error&) { // of an image that nothing uses
        }
    };
    root()["buffers"].each(add);
    root()["images"].each(add);
    root()["scenes"].each([&](const JsonView& scene) {
        if (scene["extras"].isObject() && scene["extras"]["environment"].exists()) add(scene["extras"]["environment"]);
    });
    return files;
}

Bytes GltfDocument::readUri(const JsonView& uri) const {
    const std::string text = uri.string();
    if (!isDataUri(text)) {
        const fs::path file = resolve(uri);
        try {
            return readFile(file);
        } catch (const Error& e) {
            throw Error(e.kind, name_ + ": " + uri.place() + ": " + e.what(), "a file of the scene was moved, renamed or left behind",
                        "copy the whole folder of the scene");
        }
    }
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos || text.rfind(";base64", comma) == std::string::npos) uri.fail("is a data: URI without base64 data");
    return decodeBase64(uri, text.substr(comma + 1));
}

void GltfDocument::readBuffers() {
    const JsonView buffers = root()["buffers"];
    std::uint64_t all = 0;
    for (std::uint32_t i = 0; i < buffers.size(); ++i) {
        const JsonView buffer = buffers.at(i);
        if (!buffer["uri"].exists() && (i != 0 || !hasBinaryChunk_))
            buffer.fail("has no uri, and the file has no binary chunk for it");
        Bytes bytes = buffer["uri"].exists() ? readUri(buffer["uri"]) : std::exchange(binaryChunk_, {});
        const std::uint64_t length = buffer["byteLength"].required().integer(1, kMaxFileBytes);
        if (bytes.size() < length)
            buffer.fail("is declared " + std::to_string(length) + " bytes long, but has " + std::to_string(bytes.size()),
                        "the file with its data is truncated or not the right one", "copy or export the scene again");
        all += length;
        if (all > kMaxFileBytes) buffer.fail("brings the buffers to more than " + std::to_string(kMaxFileBytes) + " bytes");
        bytes.resize(length);
        bytes.shrink_to_fit(); // many may name parts of one large file
        buffers_.push_back(std::move(bytes));
    }
}

std::span<const std::uint8_t> GltfDocument::bufferView(int i) const {
    const tinygltf::BufferView& view = model_.bufferViews[std::size_t(i)];
    return std::span(model_.buffers[std::size_t(view.buffer)].data).subspan(view.byteOffset, view.byteLength);
}

Bytes GltfDocument::imageBytes(std::uint32_t i) const {
    const int view = model_.images[i].bufferView;
    if (view < 0) return readUri(root()["images"].at(i)["uri"]);
    const std::span<const std::uint8_t> bytes = bufferView(view);
    return {bytes.begin(), bytes.end()};
}

// tinygltf asks us for buffers by our tokens, whatever their names in the scene. Images stay where they are until somebody needs
// them: the sum of their files has no bound.
void GltfDocument::buildModel() {
    tinygltf::TinyGLTF reader;
    tinygltf::FsCallbacks files{};
    files.user_data = this;
    files.FileExists = [](const std::string& token, void*) { return token.rfind(kBufferToken, 0) == 0; };
    files.ExpandFilePath = [](const std::string& token, void*) { return token; };
    files.ReadWholeFile = [](Bytes* bytes, std::string*, const std::string& token, void* self) {
        const std::size_t index = std::stoul(token.substr(std::strlen(kBufferToken)));
        *bytes = std::move(static_cast<GltfDocument*>(self)->buffers_.at(index));
        return true;
    };
    reader.SetFsCallbacks(files);
    const auto leave = [](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) { return true; };
    reader.SetImageLoader(leave, nullptr);
    const std::string text = rewrittenForTinyGltf(json_).dump();
    std::string error, warning;
    if (text.size() > std::numeric_limits<unsigned>::max()) root().fail("is longer than 4 GiB", "the file is damaged", "split the scene");
    if (!reader.LoadASCIIFromString(&model_, &error, &warning, text.data(), unsigned(text.size()), "") || !error.empty())
        root().fail("is refused by tinygltf: " + error.substr(0, error.find('\n')));
}

} // namespace cmpg
