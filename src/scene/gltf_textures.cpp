// From a textureInfo of a material to texels and how they are addressed.
#include "scene/gltf_textures.h"

#include <cmath>

namespace cmpg {
namespace {

// Decoded images kept at once; several huge ones are decoded again rather than held together.
constexpr std::size_t kCacheBytes = std::size_t(256) << 20;

Wrap wrapMode(const JsonView& mode) {
    switch (mode.integer(10497, 65535)) {
    case 10497: return Wrap::Repeat;
    case 33071: return Wrap::Clamp;
    case 33648: return Wrap::Mirror;
    default: mode.fail("is not a wrap mode of glTF");
    }
}

// KHR_texture_transform: translation * rotation * scale, the rotation counter-clockwise as seen with v pointing down.
glm::mat3x2 uvTransform(const JsonView& transform) {
    const glm::vec2 offset = transform["offset"].vec(glm::vec2(0)), scale = transform["scale"].vec(glm::vec2(1));
    const double angle = transform["rotation"].number(0);
    const float c = float(std::cos(angle)), s = float(std::sin(angle));
    return {c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y};
}

} // namespace

std::optional<TextureUse> readTextureUse(GltfLoad& load, const JsonView& info) {
    if (!info.exists()) return std::nullopt;
    const JsonView textures = load.root["textures"], samplers = load.root["samplers"], images = load.root["images"];
    const auto index = info["index"].index(textures.size(), "texture");
    if (!index) info["index"].fail("is missing");
    const JsonView texture = textures.at(*index);
    const auto image = texture["source"].index(images.size(), "image");
    if (!image) {
        for (const std::string& extension : texture["extensions"].keys()) load.ignored.insert(extension);
        load.warn(info.place() + " has no image in a format that is read, and counts as absent");
        return std::nullopt;
    }
    TextureUse use;
    use.image = *image;
    use.linear = images.at(*image)["extras"].isObject() && images.at(*image)["extras"]["colorSpace"].string("") == "linear";
    if (const auto sampler = texture["sampler"].index(samplers.size(), "sampler")) {
        use.wrapU = wrapMode(samplers.at(*sampler)["wrapS"]);
        use.wrapV = wrapMode(samplers.at(*sampler)["wrapT"]);
        use.nearest = samplers.at(*sampler)["magFilter"].integer(9729, 65535) == 9728;
    }
    const JsonView transform = info["extensions"]["KHR_texture_transform"];
    use.uvTransform = uvTransform(transform);
    const std::uint64_t texcoord = transform["texCoord"].integer(info["texCoord"].integer(0, 65535), 65535);
    if (texcoord > 1)
        load.warn(info.place() + " uses TEXCOORD_" + std::to_string(texcoord) + "; only sets 0 and 1 are read, and 0 is used instead");
    use.texcoord = texcoord == 1 ? 1 : 0;
    return use;
}

Bytes readImageBytes(GltfDocument& document, std::uint32_t image) {
    const JsonView view = document.root()["images"].at(image);
    if (view["uri"].exists()) return document.readUri(view["uri"]);
    const auto index = view["bufferView"].index(document.root()["bufferViews"].size(), "buffer view");
    if (!index) view.fail("has neither uri nor bufferView");
    const std::span<const std::uint8_t> bytes = document.bufferView(*index);
    return {bytes.begin(), bytes.end()};
}

const RawImage& ImageCache::get(std::uint32_t image) {
    const auto found = images_.find(image);
    if (found != images_.end()) return found->second;
    if (bytes_ > kCacheBytes) {
        images_.clear();
        bytes_ = 0;
    }
    const JsonView view = load_.root["images"].at(image);
    std::string name = load_.document.name() + ": " + view.place();
    const std::string uri = view["uri"].string("");
    if (!uri.empty() && !isDataUri(uri)) name += " (" + uri + ")";
    const std::size_t edge = load_.options.maxTextureSize;
    RawImage decoded = decodeImage(readImageBytes(load_.document, image), name, {.maxEdge = edge, .maxPixels = edge * edge});
    bytes_ += decoded.bytes.size() + decoded.values.size() * sizeof(float);
    return images_.emplace(image, std::move(decoded)).first->second;
}

} // namespace cmpg
