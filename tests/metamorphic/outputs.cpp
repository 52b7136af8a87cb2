#include "outputs.h"

#include "random_scene.h"

namespace cmpg::test {
namespace {

RenderConfig smallConfig() {
    RenderConfig config;
    config.maxDepth = 4;
    config.memoryBudget = std::uint64_t(16) << 20;
    return config;
}

} // namespace

Sources sameParameters(const Scene& scene) {
    Sources sources(scene.parameters.size());
    for (std::uint32_t p = 0; p < sources.size(); ++p)
        sources[p].parameter = p;
    return sources;
}

std::vector<bool> differentiated(const Scene& scene) {
    std::vector<bool> wanted(scene.parameters.size(), false);
    std::vector<bool> used(scene.materials.size(), false);
    for (const Triangle& t : scene.geometry.triangles)
        used[t.material] = true;
    for (std::uint32_t m = 0; m < scene.materials.size(); ++m)
        for (std::uint32_t k = 0; used[m] && k < kCommonSlots; ++k) {
            const SlotKind kind = SlotKind(k);
            wanted[scene.materials[m].parameters[k]] = kind == SlotKind::Normal ? scene.materials[m].hasNormalMap : kind != SlotKind::Emission || emits(scene, m);
        }
    if (scene.environment)
        wanted[scene.environment->parameter] = true;
    return wanted;
}

Image adjointImage() {
    Image adjoint(kImageEdge, kImageEdge, 3);
    std::mt19937 random(5);
    for (float& a : adjoint.values)
        a = 0.5f + float(random() >> 8) * 0x1p-24f;
    return adjoint;
}

Outputs run(const Scene& scene, const Setup& setup, const Directions& directions, const Passes& passes) {
    RenderConfig config = smallConfig();
    config.allFeatures = true; // few kernels for all scenes
    config.lightSampling = setup.lightSampling;
    config.sampler = setup.sampler;
    config.guiding = setup.guided != Sampling::Bsdf || setup.roulette;
    config.guideShare = setup.guideShare;
    config.guide.cellRecords = 200;
    Directions along;
    for (std::uint32_t p = 0; p < directions.size(); ++p)
        if (!directions[p].empty()) {
            config.differentiable.push_back(p);
            along.push_back(directions[p]);
        }
    Scene own = scene;
    for (const std::uint32_t p : config.differentiable)
        own.parameters[p].materialise();
    Renderer renderer(device(), own, config);
    const View view = viewOf(own, kImageEdge, kImageEdge);
    const Image adjoint = adjointImage();
    std::vector<std::vector<double>> gradients;
    double reference = 0;
    for (std::uint32_t i = 0; config.guiding && i < 2; ++i) {
        reference = renderer.reverse(view, 16, {passes.firstSeed, i, 3}, adjoint, {}, {}, gradients, {.record = true}).reference;
        renderer.updateGuide();
    }
    Outputs out;
    for (std::uint32_t i = 0; i < passes.count; ++i) {
        const PassKey key{passes.firstSeed, i, 0};
        const PassPlan plan{.method = {setup.guided}};
        out.image.push_back(renderer.render(view, passes.spp, key, plan));
        out.forward.push_back(renderer.forward(view, passes.spp, key, config.differentiable, along, plan));
        gradients.clear();
        renderer.reverse(view, passes.spp, key, adjoint, {}, {}, gradients, {.method = {setup.guided, setup.roulette}, .reference = reference});
        out.reverse.emplace_back(directions.size());
        for (std::size_t k = 0; k < gradients.size(); ++k)
            out.reverse.back()[config.differentiable[k]] = gradients[k];
    }
    for (const auto& [what, count] : renderer.statistics().dropped)
        if (count > 0)
            out.trouble.append(what).append(" ").append(std::to_string(count)).append("; ");
    return out;
}

std::vector<Image> images(Scene scene, const Passes& passes) {
    Renderer renderer(device(), scene, smallConfig());
    const View view = viewOf(scene, kImageEdge, kImageEdge);
    std::vector<Image> result;
    for (std::uint32_t i = 0; i < passes.count; ++i)
        result.push_back(renderer.render(view, passes.spp, {passes.firstSeed, i, 0}, {}));
    return result;
}

Directions pushed(const Directions& directions, const Sources& sources, const Scene& there) {
    Directions moved(sources.size());
    for (std::size_t p = 0; p < sources.size(); ++p) {
        const Source& s = sources[p];
        if (s.parameter == ~0u || directions[s.parameter].empty())
            continue;
        moved[p].resize(there.parameters[p].entries());
        for (std::size_t i = 0; i < moved[p].size(); ++i)
            moved[p][i] = s.scale * directions[s.parameter][s.index.empty() ? i : s.index[i]];
    }
    return moved;
}

void pull(const std::vector<std::vector<double>>& there, const Sources& sources, double weight, std::vector<std::vector<double>>& here) {
    for (std::size_t p = 0; p < sources.size(); ++p) {
        const Source& s = sources[p];
        if (s.parameter == ~0u || there[p].empty())
            continue;
        for (std::size_t i = 0; i < there[p].size(); ++i)
            here[s.parameter][s.index.empty() ? i : s.index[i]] += weight * double(s.scale) * there[p][i];
    }
}

} // namespace cmpg::test
