// Runs passes: batch after batch through the kernels.
#include "render/pass_runner.h"

#include "render/moment_sum.h"

#include <chrono>

namespace cmpg {

using gpu::kModeDifference, gpu::kModeReverse;

PassRunner::PassRunner(Device& device, const FeatureSet& features, const SceneBuffers& buffers, std::optional<Guide>& guide, const RenderConfig& config)
    : kernels(device, features, buffers, guide ? &guide->buffers : nullptr, config), device_(device), buffers_(buffers), guide_(guide), config_(config) {}

PassRunner::Outcome PassRunner::run(const FeatureSet::Pass& pass, const PassInput& in,
                                    const std::function<void(std::size_t, const Gathered&)>& receive) {
    const bool film = bool(receive), layers = pass.layers;
    if (guide_)
        guide_->publish();
    PassKernels::Kernels& k = prepare(pass);
    if (countersOpen_)
        countDropped();
    countersOpen_ = true;
    if (guide_)
        guide_->beginPass(pass, in.plan, in.spp);
    Commands commands(device_);
    k.wavefront.recordCommands(commands, buffers_, pools(), guideBuffers(), film, in.plan.keepRecords && !in.pilot);

    const bool differences = pass.mode == kModeDifference;
    const std::size_t pixels = std::size_t(in.width) * in.height;
    // Copies of split paths need space; how much shows as the pass continues. Results do not depend on it.
    std::uint32_t most = pass.roulette ? std::min(rouletteCapacity_, pools().capacity) : pools().capacity;
    std::vector<std::uint32_t> offsets;
    std::vector<gpu::FilmPixel> tile, differenceTile;
    std::vector<gpu::LayerSample> layerTile;
    Gathered carry;
    BatchStart next;
    PassResult result;
    MomentSum moments;
    while (next.pixel < pixels) {
        const BatchStart start = next;
        const bool bounded = interaction.submissionSeconds > 0;
        const gpu::Batch batch = nextBatch(in, bounded ? std::min(most, k.batchSize.paths()) : most, next, offsets);
        const bool split = next.sample > 0;
        pools().batch.upload(std::as_bytes(std::span(&batch, 1)));
        pools().pixelOffsets.uploadAll(offsets);
        std::vector<gpu::QueueCounts> counts(config_.maxDepth + 1);
        counts[0].rays = batch.paths;
        counts[0].rayGroups = {(batch.paths + gpu::kTraceChunk - 1) / gpu::kTraceChunk, 1, 1};
        counts[0].sortGroups = counts[0].rayGroups;
        counts[0].vertexGroups = {(batch.paths + gpu::kVertexGroup - 1) / gpu::kVertexGroup, 1, 1};
        counts[0].arrivalGroups = counts[0].vertexGroups;
        pools().counts.uploadAll(counts);
        if (film) {
            beginTile(tile, batch, in.film ? &in.film->pixels : nullptr, carry.film);
            pools().film.uploadAll(tile);
            if (layers) {
                beginTile(layerTile, batch, in.film ? &in.film->layerSums : nullptr, carry.layers);
                pools().layerFilm.uploadAll(layerTile);
            }
            if (differences) {
                beginTile<gpu::FilmPixel>(differenceTile, batch, nullptr, carry.difference);
                pools().differenceFilm.uploadAll(differenceTile);
            }
        }
        if (pass.mode == kModeReverse)
            pools().adjoint.uploadAll(adjointTile(in, batch));
        submit(commands, batch.paths, k.batchSize);
        counts = pools().counts.downloadAll<gpu::QueueCounts>(config_.maxDepth);
        if (counts[0].overflow) {
            next = start;
            most = std::max(1u, batch.paths / 2);
            continue;
        }
        if (pass.roulette && !in.pilot)
            most = rouletteCapacity_ = capacityFor(batch, counts);
        countRays(counts, result);
        if (pass.measure && !in.pilot) {
            const auto found = pools().pathMoments.downloadAll<gpu::PathMoment>(batch.paths);
            for (std::uint32_t p = 0; p < batch.pixels; ++p)
                for (std::uint32_t i = offsets[p]; i < offsets[p + 1]; ++i)
                    moments.add(batch.firstPixel + p, found[i]);
        }
        if (!film)
            continue;
        tile = pools().film.downloadAll<gpu::FilmPixel>(batch.pixels);
        if (layers)
            layerTile = pools().layerFilm.downloadAll<gpu::LayerSample>(batch.pixels);
        if (differences)
            differenceTile = pools().differenceFilm.downloadAll<gpu::FilmPixel>(batch.pixels);
        const auto gathered = [&](std::size_t i) {
            return Gathered{tile[i], differences ? differenceTile[i] : gpu::FilmPixel{}, layers ? layerTile[i] : gpu::LayerSample{}};
        };
        const std::size_t complete = batch.pixels - (split ? 1 : 0);
        for (std::size_t i = 0; i < complete; ++i)
            receive(batch.firstPixel + i, gathered(i));
        carry = split ? gathered(complete) : Gathered{};
    }
    if (pass.measure && !in.pilot) {
        result.variance = moments.variance();
        result.reference = moments.reference() / double(pixels);
        result.concentration = moments.concentration();
    }
    return {result, countDropped()};
}

void PassRunner::submit(Commands& commands, std::uint32_t paths, BatchSize& batchSize) const {
    if (interaction.beforeSubmission)
        interaction.beforeSubmission();
    const auto start = std::chrono::steady_clock::now();
    commands.submitAndWait();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    if (interaction.submissionSeconds > 0)
        batchSize.observe(paths, taken.count(), interaction.submissionSeconds);
}

// Paths of the next batch, from how many vertices the last one's made at their fullest bounce.
std::uint32_t PassRunner::capacityFor(const gpu::Batch& batch, const std::vector<gpu::QueueCounts>& counts) const {
    constexpr double kReserve = 0.8;
    std::uint32_t fullest = 1;
    for (const gpu::QueueCounts& c : counts)
        fullest = std::max(fullest, c.vertices);
    const double fits = kReserve * kernels.pools().capacity * double(std::max(batch.paths, 1u)) / fullest;
    return std::uint32_t(std::clamp(fits, 1.0, double(kernels.pools().capacity)));
}

void PassRunner::countRays(const std::vector<gpu::QueueCounts>& counts, PassResult& result) {
    statistics.paths += counts[0].rays;
    result.paths += counts[0].rays;
    for (const gpu::QueueCounts& c : counts) {
        const std::uint64_t rays = std::uint64_t(c.rays) + c.shadowRays;
        statistics.rays += rays;
        result.rays += rays;
        statistics.dropped["trace: unfinished rays"] += c.unfinished;
        if (c.drawn == 0)
            continue;
        statistics.guided.resize(config_.maxDepth);
        GuidedDepth& depth = statistics.guided[std::size_t(&c - counts.data())];
        depth.drawn += c.drawn;
        depth.guided += c.guided;
        depth.dead += c.dead;
        depth.lightShare += double(c.lightShare) / gpu::kShareUnits;
    }
}

Unsummed PassRunner::countDropped() {
    auto counters = pools().statistics.downloadAll<std::uint32_t>(gpu::kStatisticsCount);
    statistics.dropped["shade_vertex: non-finite radiance"] += counters[gpu::kDroppedRadiance];
    statistics.dropped["scan_tape: non-finite derivative"] += counters[gpu::kDroppedDerivative];
    statistics.dropped["gather_film: non-finite sample"] += counters[gpu::kDroppedPixel];
    statistics.dropped["scan_tape: saturated guide record"] += counters[gpu::kSaturatedRecord];
    const Unsummed unsummed{counters[gpu::kSaturatedGradient], counters[gpu::kLostGradient] != 0};
    std::fill(counters.begin(), counters.end(), 0u);
    pools().statistics.uploadAll(counters);
    countersOpen_ = false;
    return unsummed;
}

} // namespace cmpg
