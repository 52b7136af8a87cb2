// What an optimisation is made of, by checksum.
#include "optimize/content_identity.h"

#include "scene/pixel_filter.h"

#include <algorithm>
#include <cstdio>
#include <type_traits>
#include <zlib.h>

namespace cmpg {
namespace {

// CRC-32 of numbers: enough to tell a change from none.
class Digest {
  public:
    template <class T> Digest& add(const std::vector<T>& values) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>); // no padding
        return add(values.data(), values.size() * sizeof(T));
    }
    template <class T>
        requires(std::is_arithmetic_v<T> || std::is_enum_v<T>)
    Digest& add(T value) {
        return add(&value, sizeof value);
    }
    template <int N> Digest& add(const glm::vec<N, float>& v) { return add(&v, sizeof v); }
    template <int N> Digest& add(const std::vector<glm::vec<N, float>>& values) { return add(values.data(), values.size() * sizeof values[0]); }
    template <int C, int R> Digest& add(const glm::mat<C, R, float>& m) { return add(&m, sizeof m); }
    std::string text() const {
        char hex[16];
        std::snprintf(hex, sizeof hex, "%08lx", sum_);
        return hex;
    }

  private:
    Digest& add(const void* data, std::size_t bytes) {
        if (bytes > 0) // crc32() takes a null pointer for a wish to begin
            sum_ = crc32_z(sum_, static_cast<const Bytef*>(data), bytes);
        return *this;
    }
    unsigned long sum_ = 0;
};

std::string geometryOf(const Scene& scene) {
    const Geometry& g = scene.geometry;
    return Digest().add(g.positions).add(g.normals).add(g.uv0).add(g.uv1).add(g.tangents).add(g.colors).add(g.triangles).text();
}

// What only other models have is as it is by default.
bool isMetallicRoughnessAlone(const Material& m) {
    const Material plain;
    return m.model == plain.model && m.smooth == plain.smooth && m.microfacets == plain.microfacets && m.roughnessIsAlpha == plain.roughnessIsAlpha &&
           m.eta == plain.eta && m.k == plain.k && m.nonlinear == plain.nonlinear && m.anisotropyByAspect == plain.anisotropyByAspect;
}

std::string materialsOf(const Scene& scene, const std::vector<std::uint32_t>& parameters) {
    Digest d;
    for (const Material& m : scene.materials) {
        for (std::size_t k = 0; k < m.parameters.size(); ++k)
            if (SlotKind(k) != SlotKind::Weight && SlotKind(k) != SlotKind::SheenRoughness && SlotKind(k) != SlotKind::SheenColor)
                d.add(m.parameters[k]); // runs without blends or sheens are as they were before there were any
        d.add(m.hasNormalMap).add(m.ior).add(m.specularColor).add(m.alphaMask).add(m.alphaCutoff).add(m.alphaFactor).add(m.alphaTexture);
        if (m.oneSided || m.coverage || m.absorption != glm::vec3(0))
            d.add(m.oneSided).add(m.coverage).add(m.absorption);
        if (!isMetallicRoughnessAlone(m))
            d.add(m.model).add(m.smooth).add(m.microfacets).add(m.roughnessIsAlpha).add(m.eta).add(m.k).add(m.nonlinear).add(m.anisotropyByAspect);
        if (m.anisotropyDirection != ~0u || hasClearcoatNormals(m))
            d.add(m.anisotropyDirection).add(m.clearcoatNormals);
        if (m.blendWith != kNoMaterial)
            d.add(m.blendWith).add(m.parameters[std::size_t(SlotKind::Weight)]);
        if (hasSheen(m))
            d.add(m.parameters[std::size_t(SlotKind::SheenRoughness)]).add(m.parameters[std::size_t(SlotKind::SheenColor)]);
    }
    for (const AlphaTexture& a : scene.alphaTextures)
        d.add(a.width).add(a.height).add(a.texcoord).add(a.wrapU).add(a.wrapV).add(a.nearest).add(a.uvTransform).add(a.alpha);
    for (const DirectionTexture& t : scene.directionTextures)
        d.add(t.width).add(t.height).add(t.texcoord).add(t.wrapU).add(t.wrapV).add(t.nearest).add(t.uvTransform).add(t.directions);
    std::string text = d.text();
    Digest others;
    for (std::uint32_t p = 0; p < scene.parameters.size(); ++p)
        if (std::find(parameters.begin(), parameters.end(), p) == parameters.end())
            for (const char c : digestOf(scene.parameters[p]))
                others.add(c);
    return text + others.text();
}

std::string lightsOf(const Scene& scene) {
    Digest d;
    for (const PunctualLight& l : scene.lights) {
        if (l.byAngle)
            d.add(l.byAngle);
        d.add(l.kind).add(l.position).add(l.direction).add(l.intensity).add(l.range).add(l.innerCos).add(l.outerCos);
    }
    if (scene.environment)
        d.add(scene.environment->parameter).add(scene.environment->rotation);
    return d.text();
}

std::string cameraOf(const View& view) {
    const Camera& c = *view.camera;
    Digest d;
    d.add(c.toWorld).add(c.orthographic).add(c.yfov).add(c.ymag).add(view.width).add(view.height);
    if (c.center != glm::vec2(0))
        d.add(c.center);
    return d.text();
}

} // namespace

std::string digestOf(const std::vector<std::uint8_t>& bytes) { return Digest().add(bytes).text(); }
std::string digestOf(const std::vector<float>& values) { return Digest().add(values).text(); }

std::string digestOf(const Parameter& p) {
    Digest d;
    d.add(p.width).add(p.height).add(p.channels).add(p.wrapU).add(p.wrapV).add(p.nearest).add(p.texcoord).add(p.uvTransform);
    return d.add(p.values).add(p.bytes).add(p.srgb).add(p.scale).add(p.bias).text();
}

std::string digestOf(const Target& target) {
    if (!target.digest.empty())
        return target.digest;
    Digest digest;
    digest.add(target.image.values).add(target.mask);
    return (target.clipped.empty() ? digest : digest.add(target.clipped)).text();
}

Checkpoint::Identity contentIdentity(const Scene& scene, const std::vector<std::uint32_t>& parameters, const std::vector<View>& views,
                                     const std::vector<Target>& targets) {
    Checkpoint::Identity identity;
    identity.emplace_back("the scene's geometry", geometryOf(scene));
    identity.emplace_back("the scene's materials", materialsOf(scene, parameters));
    identity.emplace_back("the scene's lights", lightsOf(scene));
    for (const std::uint32_t p : parameters)
        identity.emplace_back("the start of " + scene.parameters[p].name, digestOf(scene.parameters[p]));
    for (std::size_t v = 0; v < views.size(); ++v) {
        std::string number;
        if (views.size() > 1)
            number.append(" ").append(std::to_string(v));
        identity.emplace_back("the camera" + number, cameraOf(views[v]));
        if (const PixelFilter& filter = views[v].camera->filter; filter.kind != PixelFilter::Kind::Box)
            identity.emplace_back("filter" + number, nameOf(filter)); // by the name of the option that changes it
        identity.emplace_back("the target" + number, digestOf(targets[v]));
    }
    return identity;
}

} // namespace cmpg
