// The scene in device memory: geometry, materials, parameter values, lights. Only what the feature set says is read is uploaded.
#pragma once

#include "scene/bvh.h"
#include "scene/bvh_split.h"
#include "scene/coat_table.h"
#include "scene/features.h"
#include "scene/light_distribution.h"
#include "shared/scene_info.h"
#include "vk/device.h"

namespace cmpg {

class SceneBuffers {
  public:
    // `scene` outlives this and holds the current values. `differentiable`: parameters with gradient entries, laid out one after the
    // other in this order. `second`: room for a second set of values.
    SceneBuffers(Device& device, Scene& scene, const FeatureSet& features, const std::vector<std::uint32_t>& differentiable, bool second);

    void bind(Bindings& bindings) const;
    void setParameter(std::uint32_t parameter, std::span<const float> values);
    // The second set of values; sampling stays at the first. Empty: the same as the first.
    void setSecond(std::uint32_t parameter, std::span<const float> values);

    std::uint32_t materialOf(std::uint32_t uploaded) const { return materialsUp_.at(uploaded); } // index into the scene's, of that on the device
    std::uint32_t bvhDepth() const { return bvh_.depth; }
    std::uint64_t gradientEntries() const { return gradientEntries_; }
    std::uint64_t gradientOffset(std::size_t i) const { return gradientOffsets_[i]; } // of differentiable[i]

  private:
    bool isDifferentiable(std::uint32_t parameter) const;
    // Is slot k of the material read through its GpuSlot, or does its constant stand in the material?
    bool isLookedUp(std::uint32_t material, std::uint32_t k) const;
    void chooseMaterials();
    void uploadGeometry(Device& device);
    void layOutValues(Device& device);
    void writeValues(std::uint32_t parameter, std::span<const float> values, std::uint32_t base);
    void layOutCoats();
    void uploadMaterials(bool second);
    void uploadCoat(std::uint32_t material, float alpha);
    std::uint32_t coatTexel(std::uint32_t material) const;
    void uploadSlots(Device& device);
    void uploadLights();
    bool emits(const Material& material) const; // now, or by a change of what is differentiated
    void boundEmitters(gpu::SceneInfo& info) const;
    void requireEntries(std::uint32_t parameter, std::size_t count) const;

    Device& device_;
    Scene& scene_;
    FeatureSet features_;
    std::vector<std::uint32_t> differentiable_;
    std::map<std::uint32_t, std::vector<float>> second_; // values that differ in the second set; of textures nothing but that they do
    bool hasSecond_ = false;
    Bvh bvh_;
    std::vector<std::uint32_t> materialsUp_, alphaTexturesUp_, directionTexturesUp_; // what is uploaded, by index into the scene's
    std::vector<std::uint32_t> materialPlace_, alphaSlot_, directionSlot_; // of the scene's: index among the uploaded, number of the slot
    std::vector<std::uint32_t> places_; // first value or packed texel of a parameter, gpu::kNone for constants
    std::vector<CoatTable> coats_;      // one for each index and distribution of rough plastics
    std::vector<Box> materialBoxes_; // of the scene's: around their triangles
    std::vector<std::uint32_t> coatOf_; // of an uploaded material: index into coats_, gpu::kNone
    std::uint32_t alphaPlace_ = 0, directionPlace_ = 0; // first packed texel of the alpha textures, of those of directions
    std::vector<std::uint64_t> gradientOffsets_;
    std::uint64_t gradientEntries_ = 0;
    std::uint32_t valueTexels_ = 0;
    Buffer nodes_, triangles_, indices_, attributes_, materials_, slots_, values_, packed_, lights_, lightDensity_, environmentCdf_, info_;
};

} // namespace cmpg
