// Runs passes: batch after batch through the kernels.
#include "render/pass_runner.h"

#include "base/communicator.h"
#include "render/moment_sum.h"
#include "render/pass_bands.h"

#include <bit>
#include <chrono>
#include <type_traits>

namespace cmpg {

using gpu::kModeDifference, gpu::kModeReverse;

PassRunner::PassRunner(Device& device, const FeatureSet& features, const SceneBuffers& buffers, std::optional<Guide>& guide, const RenderConfig& config)
    : kernels(device, features, buffers, guide ? &guide->buffers : nullptr, config), device_(device), features_(features), buffers_(buffers), guide_(guide), config_(config) {}

// What a pass has left so far.
struct PassRunner::Progress {
    explicit Progress(std::uint32_t depths) : counts(depths) {}
    std::uint32_t most = 0;    // paths of a batch, as the pools allow
    std::vector<Counts> counts; // by depth, at least one
    MomentSum moments;
    static_assert(std::is_trivially_copyable_v<MomentSum>); // it travels
    std::vector<std::vector<LateMoment>> late; // by band, where ranks share the pass; else `moments` has them
};

Communicator& PassRunner::ranks() const { return config_.ranks ? *config_.ranks : oneRank(); }

PassRunner::Outcome PassRunner::run(const FeatureSet::Pass& pass, const PassInput& in,
                                    const std::function<void(std::size_t, const Gathered&)>& receive) {
    // A pilot image is too small to be shared: each rank makes the whole one.
    Communicator& ranks = in.pilot ? oneRank() : this->ranks();
    if (guide_)
        guide_->publish();
    PassKernels::Kernels& k = prepare(pass);
    if (countersOpen_)
        countDropped(oneRank());
    countersOpen_ = true;
    if (guide_)
        guide_->beginPass(pass, in.plan, in.spp);
    Commands commands(device_);
    k.wavefront.recordCommands(commands, buffers_, pools(), guideBuffers(), bool(receive), in.plan.keepRecords && !in.pilot);

    // Copies of split paths need space; how much shows as the pass continues. Results do not depend on it.
    Progress progress(config_.maxDepth);
    progress.most = pass.roulette ? std::min(rouletteCapacity_, pools().capacity) : pools().capacity;
    const std::size_t pixels = std::size_t(in.width) * in.height;
    const std::vector<PixelBand> bands = pixelBands(in, ranks.size());
    const bool shared = ranks.size() > 1;
    std::optional<BandFilm> film;
    if (shared && receive)
        film.emplace(pixels, pass.mode == kModeDifference, pass.layers);
    if (in.firstVertices) {
        in.firstVertices->begin.assign(1, 0);
        for (std::size_t pixel = 0; pixel < pixels; ++pixel)
            in.firstVertices->begin.push_back(in.firstVertices->begin.back() + in.samples(pixel));
        in.firstVertices->vertices.resize(in.firstVertices->begin.back());
    }
    for (const PixelBand& band : bands) {
        if (shared)
            progress.late.emplace_back();
        if (band.rank == ranks.rank())
            runBand(pass, in, band, commands, k.batchSize, progress,
                    film ? [&](std::size_t pixel, const Gathered& g) { film->set(pixel, g); } : receive);
    }
    PassResult result;
    countRays(progress.counts, ranks, result);
    if (film) {
        film->share(ranks, bands);
        for (std::size_t pixel = 0; pixel < pixels; ++pixel)
            receive(pixel, film->get(pixel));
    }
    if (in.firstVertices && shared)
        shareFirstVertices(*in.firstVertices, ranks, bands);
    if (pass.measure && !in.pilot) {
        // In the order of the pixels: the sum goes from rank to rank.
        for (std::size_t b = 0; b < progress.late.size(); ++b) {
            for (const LateMoment& late : progress.late[b])
                progress.moments.add(late.pixel, late.moment);
            ranks.broadcast(std::as_writable_bytes(std::span(&progress.moments, 1)), bands[b].rank);
        }
        result.variance = progress.moments.variance();
        result.reference = progress.moments.reference() / double(pixels);
        result.concentration = progress.moments.concentration();
    }
    return {result, countDropped(ranks)};
}

void PassRunner::runBand(const FeatureSet::Pass& pass, const PassInput& in, const PixelBand& band, Commands& commands, BatchSize& batchSize,
                         Progress& progress, const std::function<void(std::size_t, const Gathered&)>& receive) {
    const bool film = bool(receive), layers = pass.layers, differences = pass.mode == kModeDifference;
    std::vector<std::uint32_t> offsets;
    std::vector<gpu::FilmPixel> tile, differenceTile;
    std::vector<gpu::LayerSample> layerTile;
    Gathered carry;
    BatchStart next{band.begin, 0};
    while (next.pixel < band.end) {
        const BatchStart start = next;
        const bool bounded = interaction.submissionSeconds > 0;
        const gpu::Batch batch = nextBatch(in, bounded ? std::min(progress.most, batchSize.paths()) : progress.most, band.end, next, offsets);
        const bool split = next.sample > 0;
        pools().batch.upload(std::as_bytes(std::span(&batch, 1)));
        std::vector<std::uint32_t> ofPixels = offsets;
        for (std::uint32_t p = 0; p < batch.pixels; ++p)
            ofPixels.push_back(in.first(batch.firstPixel + p));
        pools().pixelOffsets.uploadAll(ofPixels);
        std::vector<gpu::QueueCounts> counts(config_.maxDepth + 1);
        counts[0].rays = batch.paths;
        for (gpu::QueueCounts& c : counts) {
            c.rayGroups = c.shadowGroups = c.arrivalGroups = c.vertexGroups = c.sortGroups = {0, 1, 1}; // kernels count in x
            std::fill(std::begin(c.classGroups), std::end(c.classGroups), glm::uvec3(0, 1, 1));
        }
        counts[0].rayGroups.x = (batch.paths + gpu::kTraceChunk - 1) / gpu::kTraceChunk;
        counts[0].arrivalGroups.x = (batch.paths + gpu::kVertexGroup - 1) / gpu::kVertexGroup;
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
        submit(commands, batch.paths, batchSize);
        counts.resize(config_.maxDepth);
        std::vector<Download> made{{&pools().counts, std::as_writable_bytes(std::span(counts))}};
        if (film)
            made.push_back({&pools().film, std::as_writable_bytes(std::span(tile))});
        if (film && layers)
            made.push_back({&pools().layerFilm, std::as_writable_bytes(std::span(layerTile))});
        if (film && differences)
            made.push_back({&pools().differenceFilm, std::as_writable_bytes(std::span(differenceTile))});
        download(made);
        if (counts[0].overflow) {
            next = start;
            progress.most = std::max(1u, batch.paths / 2);
            continue;
        }
        if (pass.roulette && !in.pilot)
            progress.most = rouletteCapacity_ = capacityFor(batch, counts);
        for (std::size_t depth = 0; depth < counts.size(); ++depth) {
            const gpu::QueueCounts& c = counts[depth];
            Counts& sum = progress.counts[depth];
            const std::uint32_t found[] = {c.rays, c.shadowRays, c.unfinished, c.drawn, c.guided, c.dead, c.lightShare};
            for (std::size_t i = 0; i < kCounts; ++i)
                sum[i] += found[i];
        }
        if (pass.measure && !in.pilot) {
            const auto found = pools().pathMoments.downloadAll<gpu::PathMoment>(batch.paths);
            for (std::uint32_t p = 0; p < batch.pixels; ++p)
                for (std::uint32_t i = offsets[p]; i < offsets[p + 1]; ++i)
                    if (progress.late.empty())
                        progress.moments.add(batch.firstPixel + p, found[i]);
                    else
                        progress.late.back().push_back({batch.firstPixel + p, found[i]});
        }
        if (in.firstVertices)
            readFirstVertices(pass, batch, offsets, *in.firstVertices);
        if (!film)
            continue;
        const auto gathered = [&](std::size_t i) {
            return Gathered{tile[i], differences ? differenceTile[i] : gpu::FilmPixel{}, layers ? layerTile[i] : gpu::LayerSample{}};
        };
        const std::size_t complete = batch.pixels - (split ? 1 : 0);
        for (std::size_t i = 0; i < complete; ++i)
            receive(batch.firstPixel + i, gathered(i));
        carry = split ? gathered(complete) : Gathered{};
    }
}

void PassRunner::readFirstVertices(const FeatureSet::Pass& pass, const gpu::Batch& batch, std::span<const std::uint32_t> offsets, FirstVertices& first) const {
    const Pools& pools = kernels.pools();
    const Pools::Bounce& bounce = pools.bounces.front();
    const std::size_t n = pools.capacity;
    const auto tape = bounce.tape.downloadAll<std::uint32_t>((gpu::kTapeSurface + (features_.texcoord1 ? gpu::kTapeTexcoord1 : 0)) * n);
    std::vector<gpu::Arrival> arrivals; // where a roulette may give each ray another place
    if (pass.roulette)
        arrivals = bounce.arrivals.downloadAll<gpu::Arrival>(batch.paths);
    for (std::uint32_t p = 0; p < batch.pixels; ++p) {
        FirstVertex* out = first.vertices.data() + first.begin[batch.firstPixel + p] + (p == 0 ? batch.firstSample : 0);
        for (std::uint32_t ray = offsets[p]; ray < offsets[p + 1]; ++ray, ++out) {
            *out = {kNoMaterial, {}, {}};
            if (pass.roulette && arrivals[ray].count == 0)
                continue;
            const std::size_t slot = pass.roulette ? arrivals[ray].first : ray;
            const auto uv = [&](std::size_t plane) { return glm::vec2(std::bit_cast<float>(tape[plane * n + slot]), std::bit_cast<float>(tape[(plane + 1) * n + slot])); };
            if (tape[slot] != gpu::kNone)
                *out = {buffers_.materialOf(tape[slot]), uv(1), features_.texcoord1 ? uv(gpu::kTapeSurface) : glm::vec2(0)};
        }
    }
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

void PassRunner::countRays(std::vector<Counts>& counts, Communicator& ranks, PassResult& result) {
    ranks.sum({counts.front().data(), counts.size() * kCounts});
    statistics.paths += std::uint64_t(counts[0][kRays]);
    result.paths += std::uint64_t(counts[0][kRays]);
    for (const Counts& c : counts) {
        const std::uint64_t rays = std::uint64_t(c[kRays] + c[kShadowRays]);
        statistics.rays += rays;
        result.rays += rays;
        statistics.dropped["trace: unfinished rays"] += std::uint64_t(c[kUnfinished]);
        if (c[kDrawn] == 0)
            continue;
        statistics.guided.resize(config_.maxDepth);
        GuidedDepth& depth = statistics.guided[std::size_t(&c - counts.data())];
        depth.drawn += std::uint64_t(c[kDrawn]);
        depth.guided += std::uint64_t(c[kGuided]);
        depth.dead += std::uint64_t(c[kDead]);
        depth.lightShare += double(c[kLightShare]) / gpu::kShareUnits;
    }
}

Unsummed PassRunner::countDropped(Communicator& ranks) {
    auto counters = pools().statistics.downloadAll<std::uint32_t>(gpu::kStatisticsCount);
    std::vector<std::int64_t> all(counters.begin(), counters.end());
    ranks.sum(all);
    statistics.dropped["shade_vertex: non-finite radiance"] += std::uint64_t(all[gpu::kDroppedRadiance]);
    statistics.dropped["scan_tape: non-finite derivative"] += std::uint64_t(all[gpu::kDroppedDerivative]);
    statistics.dropped["gather_film: non-finite sample"] += std::uint64_t(all[gpu::kDroppedPixel]);
    statistics.dropped["scan_tape: saturated guide record"] += std::uint64_t(all[gpu::kSaturatedRecord]);
    const Unsummed unsummed{std::uint32_t(all[gpu::kSaturatedGradient]), all[gpu::kLostGradient] != 0};
    std::fill(counters.begin(), counters.end(), 0u);
    pools().statistics.uploadAll(counters);
    countersOpen_ = false;
    return unsummed;
}

} // namespace cmpg
