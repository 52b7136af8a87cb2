// The gradient sums on the device.
#include "render/gradient_sums.h"

namespace cmpg {
namespace {

constexpr std::uint64_t kPortion = 1u << 20; // entries that are on the host at a time
constexpr std::int64_t kResolved = 1 << 20; // units the largest sum of a pass should have, or rounding to whole ones shows

} // namespace

void clearSums(Buffer& sums, std::uint64_t entries) {
    const std::vector<std::int64_t> zeros(std::min(entries, kPortion), 0);
    for (std::uint64_t at = 0; at < entries; at += zeros.size())
        sums.upload(std::as_bytes(std::span(zeros)).first(8 * std::min<std::uint64_t>(zeros.size(), entries - at)), 8 * at);
}

void shareSums(Buffer& sums, std::uint64_t entries, Communicator& ranks) {
    if (ranks.size() == 1)
        return;
    for (std::uint64_t at = 0; at < entries; at += kPortion) {
        std::vector<std::int64_t> portion = sums.downloadAll<std::int64_t>(std::min(kPortion, entries - at), 8 * at);
        sumSparse(ranks, portion);
        sums.uploadAll(portion, 8 * at);
    }
}

bool resolved(const Buffer& sums, std::uint64_t entries, const Unsummed& unsummed) {
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
        for (std::uint64_t at = 0; at < p.entries(); at += kPortion) {
            const auto found = sums.downloadAll<std::int64_t>(std::min<std::uint64_t>(kPortion, p.entries() - at), 8 * (buffers.gradientOffset(i) + at));
            for (std::size_t k = 0; k < found.size(); ++k)
                gradients[i][at + k] += double(found[k]) * unit;
        }
    }
}

} // namespace cmpg
