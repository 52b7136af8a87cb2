// Puts a scene together for the importers.
#include "scene/scene_builder.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cmpg {
namespace {

bool emitsLight(const Parameter& p) {
    const auto positive = [](auto v) { return v > 0; };
    if (p.bytes.empty())
        return std::any_of(p.values.begin(), p.values.end(), positive);
    return (p.scale.x > 0 || p.scale.y > 0 || p.scale.z > 0) && std::any_of(p.bytes.begin(), p.bytes.end(), positive);
}

// Looks along -Z at the bounding sphere, which just fits a square image.
Camera framingCamera(const Geometry& geometry) {
    glm::vec3 low(0), high(0);
    for (const glm::vec3& p : geometry.positions) {
        const bool first = &p == geometry.positions.data();
        low = first ? p : glm::min(low, p);
        high = first ? p : glm::max(high, p);
    }
    Camera camera;
    camera.name = "default";
    const float radius = std::max(0.5f * glm::length(high - low), std::numeric_limits<float>::min());
    camera.toWorld[3] = glm::vec4((low + high) * 0.5f + glm::vec3(0, 0, radius / std::sin(camera.yfov / 2)), 1);
    return camera;
}

} // namespace

bool hasLight(const Scene& scene) {
    return !scene.lights.empty() || scene.environment || std::any_of(scene.parameters.begin(), scene.parameters.end(), [](const Parameter& p) {
        return p.kind == SlotKind::Emission && emitsLight(p);
    });
}

std::string uniqueName(std::string name, UniqueNames& taken) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = '_'; // names are printed on terminals
    const auto [like, isNew] = taken.try_emplace(name, 1);
    while (!isNew) {
        std::string numbered = name + "#" + std::to_string(++like->second);
        if (taken.try_emplace(numbered, 1).second)
            return numbered;
    }
    return name;
}

void SceneBuilder::warn(const std::string& text) {
    if (warned_.insert(text).second)
        scene.warnings.push_back(text);
}

void SceneBuilder::addTextureBytes(std::uint64_t bytes, const std::string& parameter) {
    textureBytes_ += bytes;
    if (textureBytes_ > options.maxTextureBytes)
        throw Error(ErrorKind::Input,
                    name_ + ": the textures are too large: up to " + parameter + " they take " + std::to_string(textureBytes_) +
                        " bytes; at most " + std::to_string(options.maxTextureBytes) + " are read",
                    "many materials have large textures, each a copy of its own", "scale the textures down");
}

Parameter& SceneBuilder::addSlot(Material& material, SlotKind kind, std::uint32_t channels, glm::vec3 constant, const std::string& name) {
    material.parameters[std::size_t(kind)] = std::uint32_t(scene.parameters.size());
    Parameter& p = scene.parameters.emplace_back();
    p.name = material.name + "." + (name.empty() ? slotName(kind) : name);
    p.kind = kind;
    p.channels = channels;
    p.values.assign(&constant[0], &constant[0] + channels);
    clampToRange(p);
    return p;
}

void SceneBuilder::clampToRange(Parameter& p) {
    if (p.kind == SlotKind::Normal)
        return; // normalised at look-up
    std::size_t outside = 0;
    for (float& v : p.values) {
        const float clamped = std::clamp(v, p.lowest(), std::min(p.highest(), kBrightest));
        outside += clamped != v;
        v = clamped;
    }
    if (outside)
        warn(p.name + ": " + std::to_string(outside) + " values outside the range of the slot were clamped");
}

void SceneBuilder::fillTexels(Parameter& p, const RawImage& image, const TextureAddress& address, const SlotTexels& texels) {
    address.apply(p);
    p.textured = true;
    p.width = image.width;
    p.height = image.height;
    const bool srgb = texels.srgb && !image.linear;
    std::array<std::uint32_t, 3> stored{};
    for (std::uint32_t c = 0; c < p.channels; ++c) {
        if (texels.channels[c] == 3 && !image.hasAlpha()) { // an image without alpha is opaque: the constant stays
            warn(p.name + ": its texture has no alpha channel; its factor is used alone");
            p.textured = false;
            p.width = p.height = 1;
            return;
        }
        stored[c] = image.channel(texels.channels[c]);
    }
    p.values.clear();
    addTextureBytes(p.entries() * (image.bytes.empty() ? sizeof(float) : 1), p.name);
    if (!image.bytes.empty()) {
        p.srgb = srgb;
        p.scale = texels.scale;
        p.bias = texels.bias;
        p.bytes.resize(p.entries());
        for (std::size_t i = 0; i < image.pixels(); ++i)
            for (std::uint32_t c = 0; c < p.channels; ++c)
                p.bytes[i * p.channels + c] = image.bytes[i * image.channels + stored[c]];
        return;
    }
    p.values.resize(p.entries());
    for (std::size_t i = 0; i < image.pixels(); ++i)
        for (std::uint32_t c = 0; c < p.channels; ++c) {
            const float code = image.values[i * image.channels + stored[c]];
            p.values[i * p.channels + c] = (srgb ? srgbDecode(code) : code) * texels.scale[int(c)] + texels.bias[int(c)];
        }
    clampToRange(p);
}

void SceneBuilder::addAlphaTexture(Material& material, const RawImage& image, const TextureAddress& address) {
    if (!image.hasAlpha())
        return;
    AlphaTexture alpha;
    address.apply(alpha);
    alpha.width = image.width;
    alpha.height = image.height;
    addTextureBytes(image.pixels(), material.name);
    alpha.alpha.resize(image.pixels());
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        const std::size_t from = i * image.channels + image.channel(3);
        const auto rounded = [](float v) { return std::uint8_t(std::lround(std::clamp(v, 0.0f, 1.0f) * 255)); };
        alpha.alpha[i] = image.bytes.empty() ? rounded(image.values[from]) : image.bytes[from];
    }
    material.alphaTexture = std::uint32_t(scene.alphaTextures.size());
    scene.alphaTextures.push_back(std::move(alpha));
}

std::uint32_t SceneBuilder::addDirections(const Material& material, const RawImage& image, const TextureAddress& address, const std::function<glm::dvec2(const glm::dvec3&)>& direction) {
    DirectionTexture texture;
    address.apply(texture);
    texture.width = image.width;
    texture.height = image.height;
    addTextureBytes(image.pixels() * sizeof(glm::vec2), material.name);
    texture.directions.resize(image.pixels());
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        glm::dvec3 v;
        for (std::uint32_t c = 0; c < 3; ++c) {
            const std::size_t from = i * image.channels + image.channel(c);
            const double code = image.bytes.empty() ? double(image.values[from]) : image.bytes[from] / 255.0;
            v[int(c)] = std::clamp(2 * code - 1, -1.0, 1.0);
        }
        texture.directions[i] = glm::vec2(direction(v));
    }
    scene.directionTextures.push_back(std::move(texture));
    return std::uint32_t(scene.directionTextures.size() - 1);
}

void SceneBuilder::addDirectionTexture(Material& material, const RawImage& image, const TextureAddress& address, double rotation) {
    const glm::dvec2 x(std::cos(rotation), std::sin(rotation)), y(-x.y, x.x);
    material.anisotropyDirection = addDirections(material, image, address, [&](const glm::dvec3& d) {
        return (d.x * x + d.y * y) / std::numbers::sqrt2; // no coordinate is above 1, however it is turned
    });
}

void SceneBuilder::addClearcoatNormals(Material& material, const RawImage& image, const TextureAddress& address, float scale) {
    material.clearcoatNormals = addDirections(material, image, address, [&](const glm::dvec3& v) {
        const glm::dvec3 n(v.x * double(scale), v.y * double(scale), std::max(v.z, 0.0));
        const double length = glm::length(n);
        return length > 1e-6 ? glm::dvec2(n) / length : glm::dvec2(0);
    });
}

void SceneBuilder::checkTexcoords(std::uint32_t material, bool uv0, bool uv1) {
    const Material& m = scene.materials[material];
    const auto check = [&](const std::string& what, std::uint32_t texcoord) {
        if (!(texcoord == 0 ? uv0 : uv1))
            warn(what + ": a mesh with this texture has no " + (texcoord == 0 ? "texture coordinates" : "second set of texture coordinates") +
                 "; the colour at (0, 0) is on all of it");
    };
    for (const std::uint32_t p : m.parameters)
        if (p != kNoParameter && scene.parameters[p].textured)
            check(scene.parameters[p].name, scene.parameters[p].texcoord);
    if (m.alphaTexture != ~0u)
        check(m.name + "'s alpha", scene.alphaTextures[m.alphaTexture].texcoord);
    if (m.blendWith != kNoMaterial)
        checkTexcoords(m.blendWith, uv0, uv1);
}

bool SceneBuilder::setEnvironment(const RawImage& image, float intensity, float rotation) {
    Parameter p;
    p.name = "environment.radiance";
    p.kind = SlotKind::Radiance;
    p.width = image.width;
    p.height = image.height;
    p.textured = image.pixels() > 1;
    p.wrapV = Wrap::Clamp;
    p.values.resize(p.entries());
    std::size_t negative = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i)
        for (std::uint32_t c = 0; c < 3; ++c) {
            const std::size_t from = i * image.channels + image.channel(c);
            const float code = image.bytes.empty() ? image.values[from] : float(image.bytes[from]) / 255.0f;
            const float value = (image.linear ? code : srgbDecode(code)) * intensity;
            negative += value < 0;
            p.values[i * 3 + c] = std::max(value, 0.0f);
        }
    if (negative)
        warn(p.name + ": " + std::to_string(negative) + " negative values were clamped to 0");
    if (!std::all_of(p.values.begin(), p.values.end(), [](float v) { return std::isfinite(v); }))
        return false;
    scene.environment = Environment{std::uint32_t(scene.parameters.size()), rotation};
    scene.parameters.push_back(std::move(p));
    return true;
}

std::optional<glm::mat4> SceneBuilder::cameraFrame(const glm::dmat4& toWorld) const {
    const glm::dmat3 m(toWorld);
    const glm::dvec3 z = glm::normalize(m[2]);
    const glm::dvec3 y = glm::normalize(m[1] - z * glm::dot(m[1], z));
    const glm::dvec3 across = m[0] - z * glm::dot(m[0], z);
    const glm::dvec3 x = glm::normalize(across - y * glm::dot(across, y));
    const double sum = glm::dot(x, x) + glm::dot(y, y) + glm::dot(z, z);
    if (!std::isfinite(sum))
        return {};
    const glm::vec3 place(glm::dvec3(toWorld[3]) - scene.center);
    return glm::mat4(glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(z, 0), glm::dvec4(place, 1)));
}

void SceneBuilder::ensureCamera() {
    if (!scene.cameras.empty())
        return;
    warn("the scene has no camera: a default one frames its bounding box from +Z");
    scene.cameras.push_back(framingCamera(scene.geometry));
}

void SceneBuilder::applyOptions() {
    const std::string file = options.environment.file.string();
    if (file.empty())
        return;
    const RawImage image = decodeImage(readFile(options.environment.file), file, imageLimits());
    setEnvironment(image, 1, options.environment.rotation);
    scene.environment->replaced = true;
}

void SceneBuilder::summarise(const std::vector<std::pair<std::uint64_t, const char*>>& left) {
    const auto join = [](const auto& parts) {
        std::string text;
        for (const std::string& part : parts)
            text += (text.empty() ? "" : ", ") + part;
        return text;
    };
    if (!ignored.empty())
        warn("not rendered: " + join(ignored));
    std::vector<std::string> skipped;
    const auto count = [&](std::uint64_t number, const char* ofWhat) {
        if (number)
            skipped.push_back(std::to_string(number) + " " + ofWhat);
    };
    count(scene.skippedTriangles, "degenerate triangles");
    for (const auto& [number, ofWhat] : left)
        count(number, ofWhat);
    if (!skipped.empty())
        warn("skipped: " + join(skipped));
    if (scene.geometry.triangles.empty())
        warn("the scene has no triangles");
    if (!hasLight(scene))
        warn("the scene has no light at all: images will be black");
}

} // namespace cmpg
