// Power-proportional light selection and the environment's two-level cumulative distribution.
#include "scene/light_distribution.h"

#include "scene/features.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cmpg {

namespace {

constexpr double kPi = std::numbers::pi;

// Mean radiance over the texels and channels; packed textures are averaged in their decoded form.
double meanValue(const Parameter& p) {
    double sum = 0;
    if (!p.values.empty()) {
        for (const float v : p.values)
            sum += v;
        return sum / double(p.values.size());
    }
    Parameter copy = p;
    copy.materialise();
    for (const float v : copy.values)
        sum += v;
    return copy.values.empty() ? 0 : sum / double(copy.values.size());
}

double area(const Geometry& g, const Triangle& t) {
    const glm::dvec3 a = g.positions[t.vertices[0]], b = g.positions[t.vertices[1]], c = g.positions[t.vertices[2]];
    return 0.5 * glm::length(glm::cross(b - a, c - a));
}

// Cumulative distribution in steps of 2^-24, those of the kernels' random numbers: inversion then draws with exactly the probability
// that the entries' differences say. What has a weight gets a step at least, as long as there are enough.
template <class Weight, class Store> void cumulate(std::size_t count, const Weight& weight, const Store& store) {
    constexpr double kSteps = 0x1p24;
    double total = 0;
    std::size_t positive = 0, last = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (!(weight(i) > 0))
            continue;
        total += weight(i);
        ++positive;
        last = i;
    }
    const double least = double(positive) <= kSteps / 2 ? 1 : 0;
    double running = 0, steps = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (weight(i) > 0) {
            running += weight(i) / total;
            steps += least;
        }
        store(i, i >= last ? 1.0f : float((std::round((kSteps - least * double(positive)) * std::min(running, 1.0)) + steps) / kSteps));
    }
}

// Of an environment's power: less above the mean tells no directions apart, and they are drawn in proportion to the whole.
constexpr double kEven = 0.01;
// What scattered rays find counts so much when a light is chosen: 0 leaves more samples to lamps, but a lamp too dim to matter would get all of them.
constexpr double kFoundPower = 0.05;

// Cells lie between neighbouring texel centres: column i between texels i and i+1 (wrapping), row j between rows j and j+1, whose
// polar angles are exactly pi j / (H-1); a map of one row has it at both poles. Weight = mean of the four corners, less `compensation` of
// the sum of their channels each, times the solid angle. Returns the total.
double environmentTables(const Parameter& p, float compensation, std::vector<float>& cdf) {
    const std::size_t w = p.width, h = p.height, rows = std::max<std::size_t>(h, 2) - 1;
    std::vector<double> weights(rows * w), rowSums(rows);
    const auto texel = [&](std::size_t x, std::size_t y) {
        const float* v = &p.values[(std::min(y, h - 1) * w + x % w) * 3];
        return std::max(0.0, (double(v[0]) + v[1] + v[2] - compensation) / 3);
    };
    double total = 0;
    for (std::size_t y = 0; y < rows; ++y) {
        const double solidAngle = 2 * kPi / double(w) * (std::cos(kPi * double(y) / double(rows)) - std::cos(kPi * double(y + 1) / double(rows)));
        for (std::size_t x = 0; x < w; ++x) {
            const double corners = texel(x, y) + texel(x + 1, y) + texel(x, y + 1) + texel(x + 1, y + 1);
            rowSums[y] += weights[y * w + x] = 0.25 * corners * solidAngle;
        }
        total += rowSums[y];
    }
    cdf.assign(rows + rows * w, 1.0f);
    if (total <= 0)
        return 0;
    cumulate(rows, [&](std::size_t y) { return rowSums[y]; }, [&](std::size_t y, float c) { cdf[y] = c; });
    for (std::size_t y = 0; y < rows; ++y) // a dark row is never drawn
        cumulate(w, [&](std::size_t x) { return weights[y * w + x]; }, [&](std::size_t x, float c) { cdf[rows + y * w + x] = c; });
    return total;
}

} // namespace

glm::vec3 faceNormal(const glm::dvec3& v0, const glm::dvec3& v1, const glm::dvec3& v2) {
    const glm::dvec3 across = glm::cross(v1 - v0, v2 - v0);
    const double length = glm::length(across);
    return length > 0 ? glm::vec3(across / length) : glm::vec3(0, 0, 1);
}

LightDistribution buildLights(const Scene& scene, const Bvh& bvh, const std::vector<std::uint32_t>& differentiable) {
    LightDistribution result;
    std::vector<double> powers;
    const Geometry& g = scene.geometry;

    std::vector<double> radiance(scene.materials.size());
    double brightest = 0;
    for (std::size_t m = 0; m < radiance.size(); ++m)
        brightest = std::max(brightest, radiance[m] = meanValue(scene.parameters[scene.materials[m].parameters[std::size_t(SlotKind::Emission)]]));
    for (std::size_t m = 0; m < radiance.size(); ++m) {
        const std::uint32_t p = scene.materials[m].parameters[std::size_t(SlotKind::Emission)];
        // Dark but differentiated: light sampling must still find it, or its derivative rests on chance hits.
        if (std::find(differentiable.begin(), differentiable.end(), p) != differentiable.end())
            radiance[m] = std::max({radiance[m], 0.01 * brightest, 1e-6});
    }
    std::vector<std::pair<std::uint32_t, double>> emissive; // light entry -> area
    for (std::uint32_t i = 0; i < bvh.order.size(); ++i) {
        const Triangle& t = g.triangles[bvh.order[i]];
        if (radiance[t.material] <= 0)
            continue;
        gpu::GpuLight light{};
        light.kind = gpu::kLightTriangle;
        light.triangle = i;
        const glm::vec3 v0 = g.positions[t.vertices[0]], v1 = g.positions[t.vertices[1]], v2 = g.positions[t.vertices[2]];
        const glm::vec3 normal = faceNormal(v0, v1, v2);
        light.position = v0;
        light.direction = v1 - v0;
        light.intensity = v2 - v0;
        light.range = normal.x;
        light.innerCos = normal.y;
        light.outerCos = normal.z;
        const double a = area(g, t);
        emissive.emplace_back(std::uint32_t(result.lights.size()), a);
        result.lights.push_back(light);
        powers.push_back(kPi * a * radiance[t.material]);
    }

    glm::dvec3 low(0), high(0);
    if (!g.positions.empty()) {
        low = high = g.positions[0];
        for (const glm::vec3& p : g.positions) {
            low = glm::min(low, glm::dvec3(p));
            high = glm::max(high, glm::dvec3(p));
        }
    }
    const double disc = kPi * std::max(1e-12, 0.25 * glm::dot(high - low, high - low));

    for (const PunctualLight& l : scene.lights) {
        gpu::GpuLight light{};
        light.position = l.position;
        light.direction = l.direction;
        light.intensity = l.intensity;
        light.range = l.range;
        light.innerCos = l.innerCos;
        light.outerCos = l.outerCos;
        const double i = meanIntensity(l);
        if (i <= 0)
            continue;
        switch (l.kind) {
        case PunctualLight::Kind::Point:
            light.kind = gpu::kLightPoint;
            powers.push_back(4 * kPi * i);
            break;
        case PunctualLight::Kind::Spot:
            light.kind = l.byAngle ? gpu::kLightSpotByAngle : gpu::kLightSpot;
            powers.push_back(2 * kPi * i * (1 - 0.5 * (double(l.innerCos) + l.outerCos)));
            break;
        case PunctualLight::Kind::Directional:
            light.kind = gpu::kLightDirectional;
            light.range = float(1 / disc);
            powers.push_back(disc * i);
            break;
        }
        result.lights.push_back(light);
    }

    if (scene.environment) {
        const std::uint32_t index = scene.environment->parameter;
        const Parameter& map = scene.parameters[index];
        double total = environmentTables(map, 0, result.environmentCdf);
        if (std::find(differentiable.begin(), differentiable.end(), index) == differentiable.end()) {
            const float compensation = float(3 * total / (4 * kPi));
            std::vector<float> cdf;
            const double above = environmentTables(map, compensation, cdf);
            if (above > kEven * total) {
                result.environmentCompensation = compensation;
                result.environmentCdf = std::move(cdf);
            }
            total = above + kFoundPower * (total - above);
        }
        if (total > 0) {
            gpu::GpuLight light{};
            light.kind = gpu::kLightEnvironment;
            result.lights.push_back(light);
            powers.push_back(disc * total);
        }
    }

    cumulate(powers.size(), [&](std::size_t i) { return powers[i]; }, [&](std::size_t i, float c) {
        result.lights[i].cumulative = c;
        result.lights[i].probability = c - (i > 0 ? result.lights[i - 1].cumulative : 0.0f);
    });
    if (!result.lights.empty() && result.lights.back().kind == gpu::kLightEnvironment) {
        gpu::GpuLight& environment = result.lights.back();
        result.environmentProbability = environment.probability;
        environment.range = float(1 / disc);
    }
    if (!emissive.empty()) {
        result.triangleDensity.assign(bvh.order.size(), 0.0f);
        for (const auto& [entry, a] : emissive) {
            float& probability = result.lights[entry].probability;
            probability = result.triangleDensity[result.lights[entry].triangle] = float(double(probability) / a);
        }
    }
    return result;
}

} // namespace cmpg
