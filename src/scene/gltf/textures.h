// From a textureInfo of a material to texels and how they are addressed.
#pragma once

#include "scene/gltf/load.h"
#include "scene/gltf/value.h"
#include "scene/image_decode.h"

#include <map>

namespace cmpg {

// `texcoord` is the number of the set in the file, of which a material as a whole keeps two.
struct TextureUse : TextureAddress {
    std::uint32_t image = 0;
    bool linear = false; // images[i].extras.colorSpace
    bool operator==(const TextureUse&) const = default;
};

// A textureInfo: of a material, of its normal texture, or inside an extension. Without index there is none.
struct TextureInfo {
    template <class Info>
    TextureInfo(const Info& info)
        : index(info.index), texcoord(info.texCoord), transform(&extension(info.extensions, "KHR_texture_transform")) {}
    TextureInfo(const tinygltf::Value& info)
        : index(int(number(member(info, "index"), -1))), texcoord(int(number(member(info, "texCoord"), 0))),
          transform(&member(member(info, "extensions"), "KHR_texture_transform")) {}

    int index, texcoord;
    const tinygltf::Value* transform; // in the model
};

// Nothing if `info` is absent, or its texture has an image only by an extension that is not supported (then a warning).
std::optional<TextureUse> readTextureUse(GltfLoad& load, const TextureInfo& info);

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
