// The steps of reading a Mitsuba scene; loadMitsuba() runs them in this order.
#pragma once

#include "scene/mitsuba/mesh.h"
#include "scene/mitsuba/object.h"
#include "scene/scene_builder.h"

namespace cmpg {

struct MitsubaLoad : SceneBuilder {
    MitsubaLoad(const MitsubaDocument& source, const LoadOptions& loadOptions) : SceneBuilder(source.name(), loadOptions), document(source) {}

    const MitsubaDocument& document;
    // What all transforms of the file are followed by: turns the scene so that its environment stands upright.
    glm::dmat4 toScene{1};
    UniqueNames materialNames, emitterNames, cameraNames;
    // Which property of which element each parameter came from, by the parameter's name.
    struct Origin {
        const MitsubaElement* owner;
        std::string property;
    };
    std::map<std::string, Origin> origins;

    // A property that means nothing here is named in one warning.
    void noteUnread(const MitsubaObject& object);
    // Its id, else `fallback` and its line.
    std::string nameOf(const MitsubaObject& object, const char* fallback);
};

// A texture: an image, how it is addressed, and whether its codes are sRGB.
struct MitsubaTexture {
    RawImage image;
    TextureAddress address;
    bool srgb = false;
};
MitsubaTexture readMitsubaTexture(MitsubaLoad& load, const MitsubaObject& texture);
// From texture coordinates to where the texture is looked up: to_uv, and what version 0.6 had beside it.
glm::mat3x2 mitsubaUvTransform(const MitsubaObject& texture);
// One channel: the luminance of colours, as Mitsuba reads a texture where it needs a number.
MitsubaTexture scalarTexture(MitsubaTexture texture);

// The material of shapes with this bsdf and emitter, either of which may be absent; made at the first call. `shape` names what has no id.
// Nothing for surfaces that are not there.
class MitsubaMaterials {
  public:
    explicit MitsubaMaterials(MitsubaLoad& load) : load_(load) {}
    std::optional<std::uint32_t> of(const MitsubaObject* bsdf, const MitsubaObject* emitter, const std::string& shape) { return of(bsdf, emitter, shape, false); }

  private:
    // `named`: `shape` is the name of a material without an id.
    std::optional<std::uint32_t> of(const MitsubaObject* bsdf, const MitsubaObject* emitter, const std::string& shape, bool named);
    Material part(const MitsubaObject& bsdf, const MitsubaObject& blend, const std::string& name);

    MitsubaLoad& load_;
    std::map<std::pair<const MitsubaElement*, const MitsubaElement*>, std::optional<std::uint32_t>> made_;
};

void loadMitsubaShapes(MitsubaLoad& load);
void loadMitsubaSensors(MitsubaLoad& load);
void loadMitsubaLights(MitsubaLoad& load); // all but area lights and the environment
// Looks for an environment and chooses toScene by it; before all else. loadMitsubaEnvironment() then adds it, after all materials.
void orientMitsubaScene(MitsubaLoad& load);
void loadMitsubaEnvironment(MitsubaLoad& load);
void loadMitsubaIntegrator(MitsubaLoad& load);

// Complex indices of refraction of named metals, as RGB; nothing for names that are not known.
struct ConductorIndex {
    glm::vec3 eta, k;
};
std::optional<ConductorIndex> conductorIndex(const std::string& name);
std::string conductorNames();
// That of a conductor, in relation to what surrounds it.
ConductorIndex conductorIndex(const MitsubaObject& bsdf);
// Real ones: "bk7", "air" ...
std::optional<double> dielectricIndex(const std::string& name);

} // namespace cmpg
