// Only what a scene requires: the same bits as with every feature on, and nothing in device memory that nobody reads.
#include "support/guided_fixture.h"
#include "support/material_json.h"
#include "support/scene_builder.h"

#include "render/scene_buffers.h"
#include "render/wavefront.h"

namespace cmpg::test {
namespace {

struct Results {
    Image image, forward;
    std::vector<std::vector<double>> gradients;
};

Results run(const Scene& scene, const std::vector<std::string>& globs, RenderConfig config, bool everything) {
    config.allFeatures = everything;
    config.maxDepth = 5;
    Bench s(scene, globs, config);
    const View view = viewOf(s.scene, 32, 24);
    Results r;
    r.image = s.renderer->render(view, 4, {3, 0, 0}, s.plan, &s.result);
    r.forward = s.renderer->forward(view, 4, {3, 0, 1}, s.config.differentiable, s.ones(), s.plan, &s.result);
    Image adjoint(view.width, view.height, 3);
    for (std::size_t i = 0; i < adjoint.values.size(); ++i)
        adjoint.values[i] = 0.1f + float(i * 7919 % 101) / 100;
    s.result = s.renderer->reverse(view, 4, {3, 0, 1}, adjoint, {}, {}, r.gradients, s.plan);
    return r;
}

// Bit by bit; an expectation of equality would print all values.
template <class T> std::size_t different(const std::vector<T>& a, const std::vector<T>& b) {
    if (a.size() != b.size())
        return std::max(a.size(), b.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        count += a[i] != b[i];
    return count;
}

void compareWithEverything(const Scene& scene, const std::vector<std::string>& globs, const RenderConfig& config = {}) {
    if (device().info().type != "cpu")
        GTEST_SKIP() << "compilers of other devices may contract differently";
    const Results own = run(scene, globs, config, false), all = run(scene, globs, config, true);
    ASSERT_GT(meanOf(own.image), 0);
    EXPECT_EQ(different(own.image.values, all.image.values), 0u) << "image";
    EXPECT_EQ(different(own.forward.values, all.forward.values), 0u) << "forward";
    ASSERT_EQ(own.gradients.size(), all.gradients.size());
    for (std::size_t i = 0; i < own.gradients.size(); ++i)
        EXPECT_EQ(different(own.gradients[i], all.gradients[i]), 0u) << "gradient " << i;
}

void compareWithEverything(const std::string& name, const std::vector<std::string>& globs, const RenderConfig& config = {}) {
    compareWithEverything(bundledScene(name), globs, config);
}

// A texture of different texels.
void makeTexture(Parameter& p, std::uint32_t width, std::uint32_t height) {
    p.width = width;
    p.height = height;
    p.values.resize(p.entries());
    for (std::size_t i = 0; i < p.values.size(); ++i)
        p.values[i] = 0.3f + 0.6f * float(i % 5) / 5;
}

TEST(Features, SameBitsBox) { compareWithEverything("box", {"painting.baseColor"}); }
TEST(Features, SameBitsBoxLight) { compareWithEverything("box", {"light.emission", "white.baseColor"}); }
TEST(Features, SameBitsFurnace) { compareWithEverything("furnace", {"*.baseColor"}); }
// SameBitsSheen has them with more lobes.
TEST(Features, FullSameBitsMaterials) { compareWithEverything("materials", {"varied.*"}); }
TEST(Features, SameBitsBowl) { compareWithEverything("bowl", {"bowl.roughness", "table.baseColor"}); }
// Its light samples have one candidate, so everything takes other kernels. Mitsuba's references see those of the scene.
TEST(Features, FullSameBitsEnvironment) { compareWithEverything("environment", {"environment.radiance"}); }
TEST(Features, SameBitsGlass) { compareWithEverything("glass", {"painting.baseColor", "ball.baseColor", "block.specular"}); }
TEST(Features, SameBitsBlend) {
    Scene scene = bundledScene("box");
    addBlend(scene, "left", "right", 0.3f);
    compareWithEverything(scene, {"left.weight", "painting.baseColor"});
}
// Under a coat, on a surface with textures; beside materials without one.
TEST(Features, SameBitsSheen) {
    Scene scene = bundledScene("materials");
    for (Material& m : scene.materials)
        if (m.name == "varied" || m.name == "brass") {
            addSheen(scene, m, {0.7f, 0.4f, 0.2f}, 0.4f);
            if (m.name == "varied")
                addClearCoat(scene, m, 0.6f, 0.3f);
        }
    compareWithEverything(scene, {"varied.sheenColor", "*.sheenRoughness", "varied.baseColor"});
}
// A coat with a normal of its own beside one that shares that of its surface.
TEST(Features, SameBitsCoatNormals) {
    Scene scene = bundledScene("materials");
    for (Material& m : scene.materials)
        if (m.name == "wavy" || m.name == "brass") {
            addClearCoat(scene, m, 0.6f, 0.3f);
            if (m.name == "brass")
                addClearcoatNormal(scene, m, {0.2f, 0.1f});
        }
    compareWithEverything(scene, {"*.clearcoat", "wavy.normal"});
}
// Textures that are looked up in one way have no code for others.
TEST(Features, SameBitsTextureLookUps) {
    Scene scene = bundledScene("box");
    Parameter& painting = scene.parameters[scene.parameter("painting.baseColor")];
    painting.wrapU = painting.wrapV = Wrap::Mirror;
    painting.nearest = true;
    painting.uvTransform = {1.5f, 0.25f, -0.5f, 2.f, 0.3f, -0.2f};
    compareWithEverything(scene, {"painting.baseColor"});
    // Beside one of one channel that is looked up in another.
    makeTexture(scene.parameters[scene.parameter("white.roughness")], 3, 2);
    compareWithEverything(scene, {"painting.baseColor", "white.roughness"});
}
TEST(Features, SameBitsWithoutLightSampling) { compareWithEverything("box", {"painting.baseColor"}, {.lightSampling = false}); }

// Guided in both: with a guide that learned alike, and drawn from it.
TEST(Features, SameBitsGuided) {
    if (device().info().type != "cpu")
        GTEST_SKIP() << "compilers of other devices may contract differently";
    std::vector<std::vector<double>> gradients[2];
    Image images[2];
    for (const bool everything : {false, true}) {
        RenderConfig config = guidedConfig();
        config.allFeatures = everything;
        GuidedBench s("door", {"painting.baseColor"}, 32, config);
        const double reference = s.train(3, 4);
        s.plan = {.method = {Sampling::Conditional, true}, .record = true, .reference = reference};
        gradients[everything] = s.gradient(4, {5, 0, 1});
        s.plan = {.method = {Sampling::Primal}};
        images[everything] = s.renderer->render(s.view, 4, {5, 0, 0}, s.plan, &s.result);
        ASSERT_GT(s.renderer->statistics().guided.size(), 0u);
    }
    EXPECT_EQ(different(gradients[0][0], gradients[1][0]), 0u);
    EXPECT_EQ(different(images[0].values, images[1].values), 0u);
}

// The pilot image of the first pass that records needs pools of its own mode; the direction must survive that.
TEST(Features, FirstRecordedForwardPassHasItsDirection) {
    const auto first = [](bool record) {
        GuidedBench s("box", {"painting.baseColor"}, 16);
        s.plan = {.record = record};
        return s.renderer->forward(s.view, 4, {5, 0, 1}, s.config.differentiable, s.directions, s.plan, &s.result);
    };
    const Image plain = first(false);
    ASSERT_GT(meanOf(plain), 0);
    EXPECT_EQ(different(plain.values, first(true).values), 0u);
}

// A derivative pass looks for the light that is a factor of some derivative, and leaves the rest out; one that records, or differentiates lamps,
// looks for all. The bits are the same.
TEST(Features, DerivativesAskForTheirLightAlone) {
    if (device().info().type != "cpu")
        GTEST_SKIP() << "compilers of other devices may contract differently";
    struct Pass {
        std::vector<double> gradient;
        Image forward;
        std::uint64_t rays = 0, forwardRays = 0;
    };
    const auto run = [](const std::vector<std::string>& globs, bool record) {
        GuidedBench s("box", globs, 24);
        s.plan = {.record = record};
        Pass p;
        p.gradient = s.gradient(4, {5, 0, 1})[0];
        p.rays = s.result.rays;
        p.forward = s.renderer->forward(s.view, 4, {5, 0, 1}, s.config.differentiable, s.directions, s.plan, &s.result);
        p.forwardRays = s.result.rays;
        return p;
    };
    const Pass own = run({"painting.baseColor"}, false), all = run({"painting.baseColor"}, true);
    EXPECT_EQ(different(own.gradient, all.gradient), 0u);
    EXPECT_EQ(different(own.forward.values, all.forward.values), 0u);
    EXPECT_LT(double(own.rays), 0.8 * double(all.rays));
    EXPECT_LT(double(own.forwardRays), 0.8 * double(all.forwardRays));
    const std::vector<std::string> withLamp = {"painting.baseColor", "light.emission"};
    EXPECT_EQ(run(withLamp, false).rays, run(withLamp, true).rays);
}

// Two squares under a lamp, one material for each; the tests add what nobody reads.
struct Room : SceneBuilder {
    std::uint32_t floor, wall, lamp;

    Room() : floor(material("floor", 0.6f, 0)), wall(material("wall", 0.4f, 0)), lamp(material("lamp", 0, 3)) {
        square(floor, 0);
        quad(wall, {-1, 1, 0}, {2, 0, 0}, {0, 0, 2});
        quad(lamp, {-0.5f, 0.5f, 1.5f}, {1, 0, 0}, {0, -1, 0});
        camera(1.4f);
    }
    Parameter& slot(std::uint32_t material, SlotKind kind) { return scene.parameters[scene.materials[material].parameters[std::size_t(kind)]]; }
    void texture(std::uint32_t material, SlotKind kind, float value, std::uint32_t edge = 64) {
        Parameter& p = slot(material, kind);
        p.width = p.height = edge;
        p.textured = true;
        p.values.assign(p.entries(), value);
    }
};

// No texture but that of the holes, in a lamp that is sampled.
TEST(Features, SameBitsAlphaMask) {
    Room room;
    Material& lamp = room.scene.materials[room.lamp];
    lamp.alphaMask = true;
    lamp.alphaTexture = 0;
    room.scene.alphaTextures = {{.width = 2, .height = 2, .nearest = true, .alpha = {0, 255, 255, 0}}};
    compareWithEverything(room.scene, {"floor.baseColor"});
}

// Where there is no environment, a path's last ray can find nothing but an emitter. The bits are the same as with all rays.
TEST(Features, LastRaysLookForEmittersAlone) {
    if (device().info().type != "cpu")
        GTEST_SKIP() << "compilers of other devices may contract differently";
    Room room;
    room.quad(room.wall, {-1, -1, 2}, {0, 2, 0}, {2, 0, 0}); // a lid: few rays leave
    const auto rays = [](const Scene& scene, bool everything) {
        Bench s(scene, {"floor.baseColor"}, RenderConfig{.maxDepth = 2, .allFeatures = everything});
        const Image image = s.renderer->render(viewOf(s.scene, 32, 24), 4, {3, 0, 0}, s.plan, &s.result);
        return std::pair(s.result.rays, image.values);
    };
    const auto [own, image] = rays(room.scene, false);
    const auto [all, imageOfAll] = rays(room.scene, true);
    EXPECT_EQ(different(image, imageOfAll), 0u);
    const std::uint64_t paths = 32 * 24 * 4;
    EXPECT_GT(all, 2 * paths); // rays to the surfaces, to the lamp, and on
    EXPECT_LT(double(own), double(all) - 0.5 * double(paths));
    EXPECT_GT(own, paths);
}

using Buffers = std::map<std::string, std::uint64_t>; // bytes

// What a renderer of the scene puts on the device before its first pass. Texel buffers are padded.
constexpr std::uint64_t kPadding = 768;
Buffers uploaded(Scene scene, RenderConfig config = {}) {
    const Renderer renderer(device(), scene, config);
    return device().memory().buffers;
}

void expectBytes(const Buffers& buffers, const char* name, std::uint64_t bytes) {
    ASSERT_TRUE(buffers.contains(name)) << name;
    EXPECT_GE(buffers.at(name), bytes) << name;
    EXPECT_LE(buffers.at(name), bytes + kPadding) << name;
}

TEST(Features, MaterialsNobodyUsesAreNotUploaded) {
    Room plain, more;
    for (int i = 0; i < 5; ++i) {
        const std::uint32_t unused = more.material("unused" + std::to_string(i), 0.5f, 9);
        more.texture(unused, SlotKind::BaseColor, 0.5f);
        more.scene.materials[unused].alphaMask = true;
        more.scene.materials[unused].alphaTexture = 0;
    }
    more.scene.alphaTextures.push_back({.width = 64, .height = 64, .alpha = std::vector<std::uint8_t>(64 * 64, 9)});
    EXPECT_EQ(uploaded(plain.scene), uploaded(more.scene));
    // Wherever it stands in the list.
    Room last;
    last.scene.materials.insert(last.scene.materials.begin(), last.scene.materials[last.lamp]);
    for (Triangle& t : last.scene.geometry.triangles)
        ++t.material;
    EXPECT_EQ(uploaded(plain.scene), uploaded(last.scene));
    Bench a(plain.scene, {}), b(last.scene, {});
    EXPECT_EQ(different(a.renderer->render(viewOf(a.scene, 16, 16), 4, {}, a.plan, &a.result).values, b.renderer->render(viewOf(b.scene, 16, 16), 4, {}, b.plan, &b.result).values), 0u);
}

TEST(Features, TexturesNobodyReadsAreNotUploaded) {
    const Room plain;
    const Buffers constant = uploaded(plain.scene);
    EXPECT_FALSE(constant.contains("parameter values"));
    EXPECT_FALSE(constant.contains("material slots"));
    EXPECT_FALSE(constant.contains("vertex attributes"));
    // A roughness without a lobe that is rough, an emission of nothing, a metal's part and a gloss of nothing.
    Room idle;
    idle.texture(idle.floor, SlotKind::Roughness, 0.3f);
    idle.texture(idle.floor, SlotKind::Emission, 0);
    idle.texture(idle.wall, SlotKind::Metallic, 0);
    idle.texture(idle.wall, SlotKind::Specular, 0);
    EXPECT_EQ(uploaded(idle.scene), constant);
    // They are as soon as they matter, or somebody asks for their derivative.
    Room glossy = idle;
    glossy.slot(glossy.floor, SlotKind::Specular).values = {0.5f};
    expectBytes(uploaded(glossy.scene), "parameter values", 64 * 64 * 4); // one float a texel
    expectBytes(uploaded(idle.scene, {.differentiable = {idle.scene.parameter("floor.emission")}}), "parameter values", 64 * 64 * 16);
    // Two texels a vertex where textures are read, one for normals alone, none without either.
    Room many;
    for (int i = 0; i < 500; ++i)
        many.square(many.floor, 0.001f * float(i));
    const std::uint64_t vertices = many.scene.geometry.positions.size();
    EXPECT_FALSE(uploaded(many.scene).contains("vertex attributes"));
    many.scene.geometry.normals.assign(vertices, glm::vec3(0, 0, 1));
    expectBytes(uploaded(many.scene), "vertex attributes", vertices * 16);
    many.texture(many.floor, SlotKind::BaseColor, 0.3f, 8);
    expectBytes(uploaded(many.scene), "vertex attributes", vertices * 32);
}

TEST(Features, LightsThatCannotBeSampledAreNotUploaded) {
    const Room plain;
    const Buffers one = uploaded(plain.scene);
    expectBytes(one, "lights", 2 * sizeof(gpu::GpuLight));
    Room dark;
    dark.scene.lights.assign(100, {.intensity = glm::vec3(0)});
    Parameter sky;
    sky.name = "environment.radiance";
    sky.kind = SlotKind::Radiance;
    sky.width = 16;
    sky.height = 8;
    sky.values.assign(sky.entries(), 0.0f);
    dark.scene.environment = Environment{std::uint32_t(dark.scene.parameters.size())};
    dark.scene.parameters.push_back(sky);
    EXPECT_EQ(uploaded(dark.scene), one);
    // Nothing is sampled without light sampling, nor at the last segment.
    for (const RenderConfig& config : {RenderConfig{.lightSampling = false}, RenderConfig{.maxDepth = 1}}) {
        Room lit;
        lit.scene.lights = {{}};
        const Buffers none = uploaded(lit.scene, config);
        for (const char* name : {"lights", "light density", "environment distribution"})
            EXPECT_FALSE(none.contains(name)) << name;
    }
    Room lit = dark;
    lit.scene.lights.assign(100, {});
    lit.scene.parameters.back().values.assign(sky.entries(), 0.1f);
    const Buffers all = uploaded(lit.scene);
    expectBytes(all, "lights", 103 * sizeof(gpu::GpuLight));
    EXPECT_TRUE(all.contains("environment distribution"));
}

// Bytes of the pools for a fixed number of paths: a pass costs what was asked for, and no more.
TEST(Features, PoolsHoldWhatPassesNeed) {
    const Room room;
    const auto pools = [&](FeatureRequest request, PoolNeeds needs) {
        const FeatureSet features = analyse(room.scene, request);
        const Pools made(device(), features, needs, std::uint64_t(2) << 30); // for the most paths that a batch has on a GPU
        return device().memory().buffers;
    };
    const std::uint32_t images = 1u << gpu::kModeRender, reverse = 1u << gpu::kModeReverse;
    const Buffers plain = pools({}, {.modes = images});
    for (const char* name : {"tape", "tangents", "prefixes", "adjoint tile", "gradient sums", "direction", "copies", "arrivals", "guide visits",
                             "derivative parts", "moments", "path moments", "layer samples", "layer tile"})
        EXPECT_FALSE(plain.contains(name)) << name;
    for (const char* name : {"shadow rays", "visibility"}) {
        EXPECT_TRUE(plain.contains(name)) << name;
        EXPECT_FALSE(pools({.lightSampling = false}, {.modes = images}).contains(name)) << name;
    }
    // Each parameter asked for takes its own planes of the tape.
    const std::uint32_t color = room.scene.parameter("floor.baseColor"), lamp = room.scene.parameter("lamp.emission");
    const PoolNeeds gradient{.modes = images | reverse, .gradientEntries = 3};
    const std::uint64_t one = pools({.differentiable = {color}}, gradient).at("tape");
    const std::uint64_t words = gpu::kTapeSurface + gpu::kTapeThroughput + 2 * gpu::kTapeDerivative;
    constexpr double kTexelPadding = 1024; // of a buffer that is read in texels
    EXPECT_NEAR(double(pools({.differentiable = {color, lamp}}, gradient).at("tape")), double(one) * (words + gpu::kTapeEmissionWeight + gpu::kTapeLight) / words,
                2 * kTexelPadding);
    const Buffers unguided = pools({.differentiable = {color}}, gradient);
    for (const char* name : {"copies", "arrivals", "guide visits", "derivative parts", "moments", "path moments", "tangents", "direction"})
        EXPECT_FALSE(unguided.contains(name)) << name;
}

// No kernel is built that no dispatch would run.
TEST(Features, KernelsAreThoseThatRun) {
    const Room room;
    const auto names = [&](const FeatureRequest& request, const FeatureSet::Pass& pass) {
        std::vector<std::string> list;
        for (const KernelChoice& k : chooseKernels(analyse(room.scene, request), pass))
            list.push_back(k.name);
        return list;
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(names({}, {.maxDepth = 1}), (Names{"generate_rays", "trace_closest", "sort_vertices", "shade_escaped", "shade_vertex", "shade_vertex", "scan_tape", "gather_film"}));
    EXPECT_EQ(names({.lightSampling = false}, {.maxDepth = 4}),
              (Names{"generate_rays", "trace_closest", "sort_vertices", "shade_escaped", "shade_vertex", "shade_vertex", "scan_tape", "gather_film"}));
    const Names all = names({}, {.roulette = true, .measure = true, .maxDepth = 4});
    EXPECT_EQ(all.size(), 11u);

    // Where a derivative pass records nothing and differentiates no lamp, plain surfaces have a kernel without light sampling, too.
    const std::uint32_t color = room.scene.parameter("floor.baseColor"), lamp = room.scene.parameter("lamp.emission");
    const auto shading = [&](const FeatureRequest& request, const FeatureSet::Pass& pass) {
        const Names list = names(request, pass);
        return std::count(list.begin(), list.end(), "shade_vertex");
    };
    for (const std::uint32_t mode : {gpu::kModeForward, gpu::kModeReverse}) {
        EXPECT_EQ(shading({.differentiable = {color}}, {.mode = mode}), 3);
        EXPECT_EQ(shading({.differentiable = {color}}, {.mode = mode, .record = true}), 2);
        EXPECT_EQ(shading({.differentiable = {color}}, {.mode = mode, .maxDepth = 1}), 2);
        EXPECT_EQ(shading({.differentiable = {color, lamp}}, {.mode = mode}), 2);
        EXPECT_EQ(shading({.differentiable = {color}, .lightSampling = false}, {.mode = mode}), 2);
    }
    EXPECT_EQ(shading({.differentiable = {color}}, {.mode = gpu::kModeDifference}), 2);
}

// What textures have in common, kernels need not look up.
TEST(Features, TexturesByWhatTheyHaveInCommon) {
    Scene scene = bundledScene("box");
    const auto bit = [](SlotKind kind) { return 1u << std::uint32_t(kind); };
    const auto textures = [&] { return analyse(scene, {}).textures; };
    EXPECT_EQ(textures().wraps, 1u << std::uint32_t(Wrap::Clamp)); // of the painting
    EXPECT_EQ(textures().colorSlots, bit(SlotKind::BaseColor));
    EXPECT_EQ(textures().scalarSlots, 0u);
    EXPECT_TRUE(textures().linear);
    EXPECT_FALSE(textures().nearest || textures().transforms);
    const auto constants = [&] { return analyse(scene, {}).constants({}); };
    EXPECT_EQ(constants()[gpu::kFeatureWrap], std::uint32_t(Wrap::Clamp));
    EXPECT_EQ(constants()[gpu::kFeatureFilter], gpu::kFilterLinear);

    Parameter& white = scene.parameters[scene.parameter("white.baseColor")];
    makeTexture(white, 2, 2);
    white.wrapV = Wrap::Mirror;
    white.nearest = true;
    white.uvTransform[2].x = 0.5f;
    EXPECT_TRUE(textures().linear && textures().nearest && textures().transforms);
    EXPECT_EQ(constants()[gpu::kFeatureWrap], gpu::kWrapsDiffer);
    EXPECT_EQ(constants()[gpu::kFeatureFilter], gpu::kFiltersDiffer);
    EXPECT_EQ(constants()[gpu::kFeatureTextureTransforms], 1u);
}

// Materials by the kernel that shades them.
TEST(Features, ShadingClasses) {
    Scene scene = bundledScene("bowl");
    const auto of = [](const Scene& s, const FeatureRequest& request, ShadingClass shadingClass) {
        const FeatureSet f = analyse(s, request);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < s.materials.size(); ++i)
            if (f.shadingClass[i] == shadingClass)
                names.push_back(s.materials[i].name);
        return names;
    };
    using Names = std::vector<std::string>;
    const auto parameter = [&](const char* name) {
        for (std::uint32_t p = 0; p < scene.parameters.size(); ++p)
            if (scene.parameters[p].name == name)
                return p;
        return ~0u;
    };
    EXPECT_EQ(of(scene, {}, ShadingClass::Plain), (Names{"wall", "floor"}));
    EXPECT_EQ(of(scene, {}, ShadingClass::Diffuse), (Names{"table", "lamp", "panel"}));
    EXPECT_EQ(of(scene, {}, ShadingClass::Other), (Names{"bowl"}));
    // What is differentiated is not plain, and a metal where that is asked for is not diffuse.
    EXPECT_EQ(of(scene, {.differentiable = {parameter("wall.baseColor")}}, ShadingClass::Plain), (Names{"floor"}));
    EXPECT_EQ(of(scene, {.differentiable = {parameter("wall.metallic")}}, ShadingClass::Other), (Names{"bowl", "wall"}));
    // Where nothing is more than diffuse there are two kernels, where all is plain there is one, and with every feature on as well.
    EXPECT_EQ(of(bundledScene("box"), {}, ShadingClass::Other), (Names{"painting", "light"}));
    EXPECT_EQ(of(bundledScene("box"), {}, ShadingClass::Diffuse), Names{});
    EXPECT_EQ(of(bundledScene("furnace"), {}, ShadingClass::Other), (Names{"wall"}));
    EXPECT_EQ(of(scene, {.everything = true}, ShadingClass::Other).size(), scene.materials.size());
}

} // namespace
} // namespace cmpg::test
