// What tells one optimisation from another: scenes that look different have different digests.
#include "optimize/content_identity.h"

#include <functional>
#include <gtest/gtest.h>
#include <set>

namespace cmpg {
namespace {

std::string digestOfMaterial(const std::function<void(Material&)>& change) {
    Scene scene;
    Material& m = scene.materials.emplace_back();
    for (std::uint32_t k = 0; k < kCommonSlots; ++k)
        m.parameters[k] = k;
    change(m);
    for (const auto& [what, digest] : contentIdentity(scene, {}, {}, {}))
        if (what == "the scene's materials")
            return digest;
    return "";
}

TEST(ContentIdentity, KnowsEverythingOfAMaterialThatImagesShow) {
    const std::pair<const char*, std::function<void(Material&)>> changes[] = {
        {"nothing", [](Material&) {}},
        {"a slot", [](Material& m) { m.parameters[0] = 7; }},
        {"a lobe's slot", [](Material& m) { m.parameters[std::size_t(SlotKind::Anisotropy)] = 7; }},
        {"normal map", [](Material& m) { m.hasNormalMap = true; }},
        {"dielectric", [](Material& m) { m.model = SurfaceModel::Dielectric; }},
        {"pane", [](Material& m) { m.model = SurfaceModel::ThinDielectric; }},
        {"conductor", [](Material& m) { m.model = SurfaceModel::Conductor; }},
        {"plastic", [](Material& m) { m.model = SurfaceModel::Plastic; }},
        {"ior", [](Material& m) { m.ior = 1.3f; }},
        {"specular colour", [](Material& m) { m.specularColor.y = 0.5f; }},
        {"smooth", [](Material& m) { m.smooth = true; }},
        {"microfacets", [](Material& m) { m.microfacets = Microfacets::Beckmann; }},
        {"glTF's roughness", [](Material& m) { m.roughnessIsAlpha = false; }},
        {"eta", [](Material& m) { m.eta.x = 0.2f; }},
        {"k", [](Material& m) { m.k.z = 3; }},
        {"absorption", [](Material& m) { m.absorption.x = 1; }},
        {"nonlinear", [](Material& m) { m.nonlinear = true; }},
        {"anisotropy's direction", [](Material& m) { m.anisotropyDirection = 0; }},
        {"coat's normals", [](Material& m) { m.parameters[std::size_t(SlotKind::Clearcoat)] = 7, m.clearcoatNormals = 0; }},
        {"aspect", [](Material& m) { m.anisotropyByAspect = true; }},
        {"blend", [](Material& m) { m.blendWith = 1; }},
        {"one side", [](Material& m) { m.oneSided = true; }},
        {"mask", [](Material& m) { m.alphaMask = true; }},
        {"coverage", [](Material& m) { m.coverage = true; }},
        {"cutoff", [](Material& m) { m.alphaCutoff = 0.25f; }},
        {"alpha", [](Material& m) { m.alphaFactor = 0.25f; }},
        {"alpha's texture", [](Material& m) { m.alphaTexture = 0; }},
    };
    std::set<std::string> digests;
    for (const auto& [what, change] : changes)
        EXPECT_TRUE(digests.insert(digestOfMaterial(change)).second) << what << " is not in it, or like another";
}

// A run that was begun before there were any can go on.
TEST(ContentIdentity, OfPlainMaterialsIsAsItWas) { EXPECT_EQ(digestOfMaterial([](Material&) {}), "05f6456400000000"); }

} // namespace
} // namespace cmpg
