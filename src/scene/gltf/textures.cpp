// From a textureInfo of a material to texels and how they are addressed.
#include "scene/gltf/textures.h"

#include <cmath>

namespace cmpg {
namespace {

// Decoded images kept at once; several huge ones are decoded again rather than held together.
constexpr std::size_t kCacheBytes = std::size_t(256) << 20;

Wrap wrapMode(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::Clamp;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::Mirror : Wrap::Repeat;
}

// KHR_texture_transform: translation * rotation * scale, the rotation counter-clockwise as seen with v pointing down.
glm::mat3x2 uvTransform(const tinygltf::Value& transform) {
    const glm::vec2 offset = vec(member(transform, "offset"), glm::vec2(0)), scale = vec(member(transform, "scale"), glm::vec2(1));
    const double angle = number(member(transform, "rotation"), 0);
    const float c = float(std::cos(angle)), s = float(std::sin(angle));
    return {c * scale.x, -s * scale.x, s * scale.y, c * scale.y, offset.x, offset.y};
}

} // namespace

std::optional<TextureUse> readTextureUse(GltfLoad& load, const TextureInfo& info) {
    if (info.index < 0) return std::nullopt;
    const tinygltf::Texture& texture = load.model.textures[std::size_t(info.index)];
    const std::string place = "textures[" + std::to_string(info.index) + "]";
    if (texture.source < 0) {
        for (const auto& [extension, value] : texture.extensions) load.ignored.insert(extension);
        load.warn(place + " has no image in a format that is read, and is left out");
        return std::nullopt;
    }
    TextureUse use;
    use.image = std::uint32_t(texture.source);
    use.linear = text(member(load.model.images[use.image].extras, "colorSpace")) == "linear";
    if (texture.sampler >= 0) {
        const tinygltf::Sampler& sampler = load.model.samplers[std::size_t(texture.sampler)];
        use.wrapU = wrapMode(sampler.wrapS);
        use.wrapV = wrapMode(sampler.wrapT);
        use.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    use.uvTransform = uvTransform(*info.transform);
    use.texcoord = std::uint32_t(number(member(*info.transform, "texCoord"), info.texcoord));
    return use;
}

const RawImage& ImageCache::get(std::uint32_t image) {
    const auto found = images_.find(image);
    if (found != images_.end()) return found->second;
    if (bytes_ > kCacheBytes) {
        images_.clear();
        bytes_ = 0;
    }
    const JsonView view = load_.document.root()["images"].at(image);
    std::string name = load_.document.name() + ": " + view.place();
    const std::string uri = view["uri"].string("");
    if (!uri.empty() && !isDataUri(uri)) name += " (" + uri + ")";
    RawImage decoded = decodeImage(load_.document.imageBytes(image), name, load_.imageLimits());
    bytes_ += decoded.bytes.size() + decoded.values.size() * sizeof(float);
    return images_.emplace(image, std::move(decoded)).first->second;
}

} // namespace cmpg
