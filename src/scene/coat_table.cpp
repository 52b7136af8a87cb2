// Quadrature over visible normals.
#include "scene/coat_table.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace cmpg {
namespace {

constexpr std::size_t kNodes = 32;
struct Rule {
    std::array<double, kNodes> at, weight; // on [0, 1]
};

// Gauss and Legendre's, by Newton's iteration.
Rule makeRule() {
    Rule rule;
    for (std::size_t i = 0; i < kNodes; ++i) {
        double x = std::cos(glm::pi<double>() * (double(i) + 0.75) / (kNodes + 0.5)), slope = 1;
        for (int step = 0; step < 50; ++step) {
            double before = 1, value = x;
            for (std::size_t n = 2; n <= kNodes; ++n) {
                const double next = (double(2 * n - 1) * x * value - double(n - 1) * before) / double(n);
                before = value;
                value = next;
            }
            slope = double(kNodes) * (x * value - before) / (x * x - 1);
            const double change = value / slope;
            x -= change;
            if (std::abs(change) < 1e-15) break;
        }
        rule.at[i] = 0.5 * (1 - x);
        rule.weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
    return rule;
}
const Rule& rule() {
    static const Rule made = makeRule();
    return made;
}

// Fresnel's term of a smooth boundary.
double fresnel(double c, double eta) {
    const double cos2 = 1 - (1 - c * c) / (eta * eta);
    if (cos2 <= 0) return 1;
    const double t = std::sqrt(cos2), s = (c - eta * t) / (c + eta * t), p = (eta * c - t) / (eta * c + t);
    return 0.5 * (s * s + p * p);
}

double maskingGgx(double alpha, double c) { return 2 * c / (c + std::sqrt(alpha * alpha + (1 - alpha * alpha) * c * c)); }

double maskingBeckmann(double alpha, double c) {
    const double s = std::sqrt(std::max(0.0, 1 - c * c));
    if (c >= 1.6 * alpha * s) return 1;
    const double a = c / (alpha * s);
    return a * (3.535 + 2.181 * a) / (1 + a * (2.276 + 2.577 * a));
}

} // namespace

CoatTable::Passed CoatTable::passed(double cosine, double alpha, double eta, Microfacets microfacets) {
    const double c = std::clamp(cosine, 1e-6, 1.0);
    if (alpha < 1e-6) return {fresnel(c, eta), 1 - fresnel(c, eta)};
    const glm::dvec3 o(std::sqrt(1 - c * c), 0, c);
    const glm::dvec3 stretched = glm::normalize(glm::dvec3(alpha * o.x, 0, o.z));
    const auto masking = microfacets == Microfacets::Beckmann ? maskingBeckmann : maskingGgx;
    Passed sum;
    for (std::size_t i = 0; i < kNodes; ++i)
        for (std::size_t k = 0; k < kNodes; ++k) { // half a turn; the other half is its mirror image
            // GGX normals that o sees, by spherical caps; Beckmann's are weighted against them.
            const double turn = glm::pi<double>() * (double(k) + 0.5) / double(kNodes);
            const double z = 1 - rule().at[i] * (1 + stretched.z), radius = std::sqrt(std::max(0.0, 1 - z * z));
            const glm::dvec3 cap = glm::dvec3(radius * std::cos(turn), radius * std::sin(turn), z) + stretched;
            const glm::dvec3 h = glm::normalize(glm::dvec3(alpha * cap.x, alpha * cap.y, std::max(cap.z, 0.0)));
            const double along = std::min(glm::dot(o, h), 1.0);
            if (along <= 0) continue;
            double weight = rule().weight[i] / double(kNodes);
            if (microfacets == Microfacets::Beckmann) {
                const double x = (1 - h.z * h.z) / (h.z * h.z * alpha * alpha);
                weight *= std::exp(-x) * (1 + x) * (1 + x) * maskingBeckmann(alpha, c) / maskingGgx(alpha, c);
            }
            const double f = fresnel(along, eta), mirrored = 2 * along * h.z - c;
            if (mirrored > 0) sum.reflected += weight * f * masking(alpha, mirrored);
            if (f == 1) continue;
            const double bent = std::sqrt(1 - (1 - along * along) / (eta * eta)), below = c / eta - h.z * (along / eta - bent); // cosine to the normal below
            if (below > 0) sum.transmitted += weight * (1 - f) * masking(alpha, below);
        }
    return sum;
}

double CoatTable::reflectedDiffuse(double eta) {
    double sum = 0;
    // In two pieces, because of the corner where total reflection begins.
    const double corner = eta < 1 ? std::sqrt(1 - eta * eta) : 0.5;
    for (std::size_t i = 0; i < kNodes; ++i) {
        const double low = corner * rule().at[i], high = corner + (1 - corner) * rule().at[i];
        sum += 2 * rule().weight[i] * (corner * low * fresnel(low, eta) + (1 - corner) * high * fresnel(high, eta));
    }
    return sum;
}

std::uint32_t CoatTable::rowOf(float alpha) {
    return std::min(std::uint32_t(std::sqrt(std::max(alpha, 0.0f)) * float(gpu::kCoatRows)), gpu::kCoatRows - 1);
}

const CoatTable::Row& CoatTable::row(std::uint32_t index) {
    const auto [found, isNew] = rows_.try_emplace(index);
    if (!isNew) return found->second;
    const double root = double(index) / double(gpu::kCoatRows), alpha = root * root;
    Row& row = found->second;
    row.within = 0;
    for (std::uint32_t i = 0; i < gpu::kCoatColumns; ++i) {
        const double cosine = double(i) / double(gpu::kCoatColumns - 1);
        row.transmitted[i] = passed(cosine, alpha, ior_, microfacets_).transmitted;
        // The mean over these nodes, both ends included, is what Mitsuba takes for the integral: 1.5 % less at an index of 1.5.
        row.within += 2 * cosine * passed(cosine, alpha, 1 / ior_, microfacets_).reflected / double(gpu::kCoatColumns);
    }
    return row;
}

void CoatTable::write(std::uint32_t first, std::uint32_t last, std::span<glm::vec4> texels) {
    for (std::uint32_t r = first; r <= last; ++r) {
        const Row &here = row(r), &next = row(r + 1);
        glm::vec4* out = &texels[std::size_t(r) * gpu::kCoatColumns];
        for (std::uint32_t i = 0; i + 1 < gpu::kCoatColumns; ++i)
            out[i] = glm::vec4(here.transmitted[i], here.transmitted[i + 1], next.transmitted[i], next.transmitted[i + 1]);
        out[gpu::kCoatColumns - 1] = glm::vec4(here.within, here.within, next.within, next.within);
    }
}

} // namespace cmpg
