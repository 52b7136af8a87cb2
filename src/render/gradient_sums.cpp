// The gradient sums on the device.
#include "render/gradient_sums.h"

namespace cmpg {
namespace {

constexpr std::int64_t kResolved = 1 << 20; // units the largest sum of a pass should have, or rounding to whole ones shows

} // namespace

void clearSums(Buffer& sums, std::uint64_t entries) {
    const std::vector<std::int64_t> zeros(std::min<std::uint64_t>(entries, 1u << 20), 0);
    for (std::uint64_t at = 0; at < entries; at += zeros.size())
        sums.upload(std::as_bytes(std::span(zeros)).first(8 * std::min<std::uint64_t>(zeros.size(), entries - at)), 8 * at);
}

void shareSums(Buffer& sums, std::uint64_t entries, Communicator& ranks) {
    constexpr std::uint64_t kPortion = 1u << 22;
    if (ranks.size() == 1)
        return;
    for (std::uint64_t at = 0; at < entries; at += kPortion) {
        std::vector<std::int64_t> portion = sums.downloadAll<std::int64_t>(std::min(kPortion, entries - at), 8 * at);
        sumSparse(ranks, portion);
        sums.uploadAll(portion, 8 * at);
    }
}

bool resolved(const Buffer& sums, std::uint64_t entries, const Unsummed& unsummed) {
    constexpr std::uint64_t kPortion = 1u << 18;
    bool contributed = unsummed.tooSmall;
    for (std::uint64_t at = 0; at < entries; at += kPortion)
        for (const std::int64_t sum : sums.downloadAll<std::int64_t>(std::min(kPortion, entries - at), 8 * at)) {
            if (sum >= kResolved || sum <= -kResolved)
                return true;
            contributed = contributed || sum != 0;
        }
    return !contributed;
}

void addSums(const Buffer& sums, const SceneBuffers& buffers, const Scene& scene, std::span<const std::uint32_t> differentiable,
             const GradientUnits& units, std::vector<std::vector<double>>& gradients) {
    gradients.resize(differentiable.size());
    for (std::size_t i = 0; i < gradients.size(); ++i) {
        const Parameter& p = scene.parameters[differentiable[i]];
        const double unit = units.unitOf(p.kind);
        gradients[i].resize(p.entries(), 0.0);
        const auto found = sums.downloadAll<std::int64_t>(p.entries(), 8 * buffers.gradientOffset(i));
        for (std::size_t k = 0; k < found.size(); ++k)
            gradients[i][k] += double(found[k]) * unit;
    }
}

} // namespace cmpg
