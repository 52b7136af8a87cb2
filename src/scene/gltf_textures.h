// From a textureInfo of a material to texels and how they are addressed.
#pragma once

#include "scene/gltf_load.h"
#include "scene/image_decode.h"

#include <map>

namespace cmpg {

struct TextureUse {
    std::uint32_t image = 0;
    bool linear = false; // images[i].extras.colorSpace
    Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
    bool nearest = false;
    std::uint32_t texcoord = 0;
    glm::mat3x2 uvTransform{1, 0, 0, 1, 0, 0};

    // Parameter or AlphaTexture.
    template <class Target> void address(Target& target) const {
        target.wrapU = wrapU;
        target.wrapV = wrapV;
        target.nearest = nearest;
        target.texcoord = texcoord;
        target.uvTransform = uvTransform;
    }
};

// Nothing if `info` is absent, or its texture has an image only by an extension that is not supported (then a warning).
std::optional<TextureUse> readTextureUse(GltfLoad& load, const tinygltf::TextureInfo& info);

// Decoded images, each usually needed by several slots of one material.
class ImageCache {
  public:
    explicit ImageCache(GltfLoad& load) : load_(load) {}
    const RawImage& get(std::uint32_t image);

  private:
    GltfLoad& load_;
    std::map<std::uint32_t, RawImage> images_;
    std::size_t bytes_ = 0;
};

} // namespace cmpg
