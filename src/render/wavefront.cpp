// Pools sized by the budget, kernels specialised by the features, commands in the order of the algorithm.
#include "render/wavefront.h"

#include "base/error.h"
#include "shared/bindings.h"
#include "shared/swizzle.h"

#include <algorithm>

namespace cmpg {

namespace {

static_assert(sizeof(gpu::QueueCounts) == 256); // a bounce's counts are a uniform buffer of their own
static_assert(gpu::kChunkRounds * gpu::kVertexGroup == gpu::kTraceChunk);

using gpu::kModeDifference, gpu::kModeForward, gpu::kModeReverse;

constexpr std::uint32_t kMinCapacity = 4096;
// Paths of a batch at most. On a CPU the pools should stay near its caches, and every dispatch waits for its threads to wake (docs/history/kernels.md);
// a GPU wants work for all its units.
constexpr std::uint32_t kMaxCapacityCpu = 1u << 17, kMaxCapacityGpu = 1u << 20;
static_assert(std::max(kMaxCapacityCpu, kMaxCapacityGpu) / gpu::kVertexGroup <= 65535); // in x alone: GROW_GROUPS in shaders/lib/dispatch.glsl

constexpr std::pair<ShadingClass, Step> kShadeSteps[] = {
    {ShadingClass::Plain, Step::ShadePlain}, {ShadingClass::Diffuse, Step::ShadeDiffuse}, {ShadingClass::Other, Step::ShadeOther},
    {ShadingClass::Unlit, Step::ShadeUnlit}};

struct PathBytes { // of one path, over all pools
    std::uint64_t batch, tapeWords, bounce;
};

PathBytes pathBytes(const FeatureSet& f, const PoolNeeds& needs) {
    std::uint64_t words = 0;
    for (const std::uint32_t mode : {kModeForward, kModeReverse, kModeDifference})
        if (needs.has(mode))
            words = std::max<std::uint64_t>(words, gpu::tapePlanes(mode, f.differentiated, f.texcoord1));
    PathBytes b{};
    b.tapeWords = words;
    const bool shadows = f.lightSampling();
    b.batch = 2 * sizeof(gpu::Ray) + sizeof(gpu::Hit) + sizeof(glm::uvec2) + 2 * sizeof(std::uint32_t) + sizeof(gpu::FilmPixel);
    b.batch += shadows ? sizeof(gpu::ShadowRay) : 0;
    b.batch += needs.has(kModeReverse) ? sizeof(glm::vec3) : 0;
    b.batch += needs.has(kModeDifference) ? sizeof(gpu::FilmPixel) : 0;
    b.batch += needs.layers ? 2 * sizeof(gpu::LayerSample) : 0;
    b.batch += needs.prefixes() ? 2 * sizeof(gpu::Prefix) : 0;
    b.batch += needs.roulette ? sizeof(gpu::Copy) : 0;
    b.batch += needs.measure ? sizeof(gpu::PathMoment) : 0;
    (needs.derivatives() ? b.bounce : b.batch) += gpu::kVertexClasses * sizeof(std::uint32_t);
    b.bounce += sizeof(gpu::Vertex) + sizeof(glm::vec4) + (shadows ? sizeof(std::uint32_t) : 0) + 4 * words + (needs.tangents() ? sizeof(glm::vec4) : 0);
    b.bounce += needs.record ? sizeof(gpu::GuideVisit) : 0;
    b.bounce += needs.derivativeRecords() ? sizeof(gpu::DerivativeParts) : 0;
    b.bounce += needs.measure ? sizeof(gpu::VertexMoment) : 0;
    b.bounce += needs.roulette ? sizeof(gpu::Arrival) : 0;
    return b;
}

} // namespace

Pools::Pools(Device& device, const FeatureSet& features, const PoolNeeds& n_, std::uint64_t budget) : needs(n_) {
    const std::uint32_t depth = needs.maxDepth;
    const PathBytes b = pathBytes(features, needs);
    const std::uint64_t perPath = b.batch + depth * b.bounce;
    std::uint64_t fits = std::min<std::uint64_t>(budget / perPath, device.info().type == "cpu" ? kMaxCapacityCpu : kMaxCapacityGpu);
    // Every pool is bound whole, so none may exceed what a binding reaches.
    const std::uint64_t widest = std::max<std::uint64_t>({4 * b.tapeWords, sizeof(gpu::Vertex), 1});
    fits = std::min(fits, device.info().maxStorageBufferRange / widest);
    if (fits < kMinCapacity)
        throw Error(ErrorKind::Usage, "a memory budget of " + std::to_string(budget >> 20) + " MiB does not hold one batch",
                    "depth " + std::to_string(depth) + " needs " + std::to_string(perPath) + " bytes a path, at least " + std::to_string(kMinCapacity) +
                        " paths",
                    "raise the memory budget to " + std::to_string((perPath * kMinCapacity >> 20) + 1) + " MiB or lower the depth", {"memory", "max-depth"});
    capacity = std::uint32_t(fits) & ~63u;

    const std::uint64_t n = capacity;
    const auto transient = [&](const char* name, std::uint64_t bytes) { return Buffer(device, name, bytes, MemoryKind::Transient); };
    const auto queue = [&](const char* name, std::uint64_t bytes) { return Buffer(device, name, bytes, MemoryKind::Transient, Texel::Rgba32ui); };
    const auto words = [&](const char* name, std::uint64_t bytes) { return Buffer(device, name, bytes, MemoryKind::Transient, Texel::R32ui); };
    batch = transient("batch", sizeof(gpu::Batch));
    pixelOffsets = words("pixel offsets", (2 * n + 1) * sizeof(std::uint32_t));
    paths = words("paths", n * sizeof(glm::uvec2));
    film = transient("film tile", n * sizeof(gpu::FilmPixel));
    statistics = transient("statistics", gpu::kStatisticsCount * sizeof(std::uint32_t));
    counts = transient("queue counts", (depth + 1) * sizeof(gpu::QueueCounts));
    for (Buffer& r : rays)
        r = queue("rays", n * sizeof(gpu::Ray));
    hits = queue("hits", n * sizeof(gpu::Hit));
    if (features.lightSampling())
        shadowRays = queue("shadow rays", n * sizeof(gpu::ShadowRay));
    if (needs.prefixes())
        for (Buffer& p : prefixes)
            p = queue("prefixes", n * sizeof(gpu::Prefix));
    if (needs.roulette)
        copies = queue("copies", n * sizeof(gpu::Copy));
    if (needs.measure)
        pathMoments = transient("path moments", n * sizeof(gpu::PathMoment));
    if (needs.layers) {
        layerSamples = transient("layer samples", n * sizeof(gpu::LayerSample));
        layerFilm = transient("layer tile", n * sizeof(gpu::LayerSample));
    }
    if (needs.has(kModeDifference))
        differenceFilm = transient("difference tile", n * sizeof(gpu::FilmPixel));
    if (needs.has(kModeReverse)) {
        adjoint = words("adjoint tile", n * sizeof(glm::vec3));
        gradients = Buffer(device, "gradient sums", needs.gradientEntries * 8, MemoryKind::Parameters);
    }
    if (needs.has(kModeForward))
        direction = Buffer(device, "direction", needs.gradientEntries * 4, MemoryKind::Parameters, Texel::R32f);
    for (std::uint32_t i = 0; i < depth; ++i) {
        Bounce bounce;
        if (i == 0 || needs.derivatives()) // the scan of derivatives goes by classes, too
            bounce.sorted = words("sorted vertices", gpu::kVertexClasses * n * sizeof(std::uint32_t));
        bounce.vertices = queue("vertices", n * sizeof(gpu::Vertex));
        bounce.suffixes = queue("suffixes", n * sizeof(glm::vec4));
        if (features.lightSampling())
            bounce.visibility = words("visibility", n * sizeof(std::uint32_t));
        if (b.tapeWords)
            bounce.tape = words("tape", n * 4 * b.tapeWords);
        if (needs.tangents())
            bounce.tangents = queue("tangents", n * sizeof(glm::vec4));
        if (needs.record)
            bounce.visits = words("guide visits", n * sizeof(gpu::GuideVisit));
        if (needs.derivativeRecords())
            bounce.derivatives = words("derivative parts", n * sizeof(gpu::DerivativeParts));
        if (needs.measure)
            bounce.moments = words("moments", n * sizeof(gpu::VertexMoment));
        if (needs.roulette)
            bounce.arrivals = words("arrivals", n * sizeof(gpu::Arrival));
        bounces.push_back(std::move(bounce));
    }
}

std::vector<KernelChoice> chooseKernels(const FeatureSet& features, const FeatureSet::Pass& pass) {
    const auto table = features.constants(pass);
    const std::vector<std::uint32_t> constants(table.begin(), table.end());
    const auto traceTable = features.traceConstants(pass.threads, pass.bvhDepth);
    const std::vector<std::uint32_t> traceConstants(traceTable.begin(), traceTable.end());
    const bool scatters = pass.maxDepth > 1;
    std::vector<KernelChoice> choice;
    const auto add = [&](bool needed, Step step, const char* name, const std::vector<std::uint32_t>& with) {
        if (needed)
            choice.push_back({step, name, with});
    };
    add(true, Step::Generate, "generate_rays", constants);
    add(true, Step::Trace, "trace_closest", traceConstants);
    add(pass.roulette, Step::Split, "split_paths", constants);
    add(true, Step::Sort, "sort_vertices", constants);
    add(true, Step::ShadeEscaped, "shade_escaped", constants);
    for (const auto& [shadingClass, step] : kShadeSteps) {
        const auto of = features.constants(pass, shadingClass);
        const bool some = shadingClass == ShadingClass::Unlit ? features.shadesUnlit(pass) : features.classes.contains(shadingClass);
        add(some || shadingClass == ShadingClass::Other, step, "shade_vertex", {of.begin(), of.end()});
    }
    add(scatters && features.lightSampling(), Step::TraceShadow, "trace_shadow", traceConstants);
    add(true, Step::Scan, "scan_tape", constants);
    auto undifferentiated = constants;
    undifferentiated[gpu::kFeatureClassDifferentiated] = false;
    add(features.scansClasses(pass), Step::ScanUndifferentiated, "scan_tape", undifferentiated);
    add(pass.measure, Step::GatherMoments, "gather_moments", constants);
    add(true, Step::GatherFilm, "gather_film", constants);
    return choice;
}

Wavefront::Wavefront(Device& device, const FeatureSet& features, const FeatureSet::Pass& pass, Wanted wanted)
    : device_(device), features_(features), pass_(pass) {
    const std::vector<KernelChoice> choices = chooseKernels(features, pass);
    std::vector<KernelRequest> requests;
    for (const KernelChoice& choice : choices)
        requests.push_back({choice.name, choice.constants});
    std::vector<Kernel> made = makeKernels(device, requests, wanted);
    for (std::size_t i = 0; i < choices.size(); ++i)
        kernels_.emplace(choices[i].step, std::move(made[i]));
}

std::vector<const Kernel*> Wavefront::kernels() const {
    std::vector<const Kernel*> all;
    for (const auto& [step, kernel] : kernels_)
        all.push_back(&kernel);
    return all;
}

std::uint64_t Wavefront::gradientSlice() const { return device_.info().maxStorageBufferRange / 8 & ~std::uint64_t(255); }

std::vector<Bindings> Wavefront::bindings(const SceneBuffers& scene, const Pools& pools, const GuideBuffers* guide) const {
    const std::uint32_t depth = pools.needs.maxDepth;
    Bindings common;
    scene.bind(common);
    if (guide)
        guide->bind(common);
    common.set(gpu::kBindCopies, pools.copies).set(gpu::kBindPathMoments, pools.pathMoments);
    common.set(gpu::kBindBatch, pools.batch).set(gpu::kBindPixelOffsets, pools.pixelOffsets).set(gpu::kBindPaths, pools.paths);
    common.set(gpu::kBindFilm, pools.film).set(gpu::kBindStatistics, pools.statistics).set(gpu::kBindCounts, pools.counts);
    common.set(gpu::kBindDifferenceFilm, pools.differenceFilm).set(gpu::kBindHits, pools.hits).set(gpu::kBindShadowRays, pools.shadowRays);
    common.set(gpu::kBindAdjoint, pools.adjoint).set(gpu::kBindDirection, pools.direction);
    common.set(gpu::kBindGradients, pools.gradients, 0, std::min(pools.gradients.size(), gradientSlice() * 8));
    common.set(gpu::kBindLayers, pools.layerSamples).set(gpu::kBindLayerFilm, pools.layerFilm);
    common.set(gpu::kBindCountsFirst, pools.counts, 0, sizeof(gpu::QueueCounts));
    std::vector<Bindings> atBounce(depth, common);
    for (std::uint32_t b = 0; b < depth; ++b) {
        const Pools::Bounce& here = pools.bounces[b];
        const Pools::Bounce& next = pools.bounces[std::min(b + 1, depth - 1)]; // the last bounce continues nothing
        atBounce[b].set(gpu::kBindCountsHere, pools.counts, b * sizeof(gpu::QueueCounts), sizeof(gpu::QueueCounts));
        atBounce[b].set(gpu::kBindSorted, pools.bounces[pools.needs.derivatives() ? b : 0].sorted);
        atBounce[b].set(gpu::kBindRays, pools.rays[b % 2]).set(gpu::kBindNextRays, pools.rays[(b + 1) % 2]);
        atBounce[b].set(gpu::kBindVertices, here.vertices).set(gpu::kBindSuffixes, here.suffixes).set(gpu::kBindNextSuffixes, next.suffixes);
        atBounce[b].set(gpu::kBindVisibility, here.visibility);
        atBounce[b].set(gpu::kBindPrefixes, pools.prefixes[b % 2]).set(gpu::kBindNextPrefixes, pools.prefixes[(b + 1) % 2]);
        atBounce[b].set(gpu::kBindTape, here.tape).set(gpu::kBindGuideVisits, here.visits);
        atBounce[b].set(gpu::kBindArrivals, here.arrivals).set(gpu::kBindNextArrivals, next.arrivals);
        atBounce[b].set(gpu::kBindDerivatives, here.derivatives).set(gpu::kBindNextDerivatives, next.derivatives);
        atBounce[b].set(gpu::kBindMoments, here.moments).set(gpu::kBindNextMoments, next.moments);
        atBounce[b].set(gpu::kBindTangents, here.tangents).set(gpu::kBindNextTangents, next.tangents);
    }
    return atBounce;
}

namespace {

// Where the workgroup counts of a bounce's dispatches stand in Pools::counts.
std::uint64_t groupsAt(std::uint32_t bounce, std::size_t member) { return bounce * sizeof(gpu::QueueCounts) + member; }
std::uint64_t rayGroups(std::uint32_t bounce) { return groupsAt(bounce, offsetof(gpu::QueueCounts, rayGroups)); }
std::uint64_t arrivalGroups(std::uint32_t bounce) { return groupsAt(bounce, offsetof(gpu::QueueCounts, arrivalGroups)); }
std::uint64_t vertexGroups(std::uint32_t bounce) { return groupsAt(bounce, offsetof(gpu::QueueCounts, vertexGroups)); }
std::uint64_t shadowGroups(std::uint32_t bounce) { return groupsAt(bounce, offsetof(gpu::QueueCounts, shadowGroups)); }
std::uint64_t sortGroups(std::uint32_t bounce) { return groupsAt(bounce, offsetof(gpu::QueueCounts, sortGroups)); }
std::uint64_t classGroups(std::uint32_t bounce, std::uint32_t shadingClass) {
    return groupsAt(bounce, offsetof(gpu::QueueCounts, classGroups) + shadingClass * sizeof(glm::uvec3));
}

} // namespace

void Wavefront::recordCommands(Commands& commands, const SceneBuffers& scene, const Pools& pools, const GuideBuffers* guide, bool film, bool keepRecords) const {
    const std::uint32_t n = pools.capacity, depth = pools.needs.maxDepth;
    const std::vector<Bindings> atBounce = bindings(scene, pools, guide);

    // As many workgroups as the batch has paths: counts the host has set, which no kernel changes.
    const auto perPath = [&](const Kernel& k) { commands.dispatchIndirect(k, atBounce[0], pools.counts, arrivalGroups(0), gpu::BouncePush{0, n, depth}); };
    perPath(kernel(Step::Generate));
    commands.barrier();
    for (std::uint32_t b = 0; b < depth; ++b) {
        const gpu::BouncePush push{b, n, depth};
        commands.dispatchIndirect(kernel(Step::Trace), atBounce[b], pools.counts, rayGroups(b), push);
        commands.barrier();
        if (pass_.roulette) {
            commands.dispatchIndirect(kernel(Step::Split), atBounce[b], pools.counts, arrivalGroups(b), push);
            commands.barrier();
        }
        commands.dispatchIndirect(kernel(Step::Sort), atBounce[b], pools.counts, pass_.roulette ? sortGroups(b) : rayGroups(b), push);
        commands.barrier();
        const auto shade = [&](Step step, std::uint32_t shadingClass) {
            if (has(step))
                commands.dispatchIndirect(kernel(step), atBounce[b], pools.counts, classGroups(b, shadingClass), push);
        };
        shade(Step::ShadeEscaped, gpu::kClassEscaped);
        for (const auto& [shadingClass, step] : kShadeSteps)
            shade(step, std::uint32_t(shadingClass));
        commands.barrier();
        if (b + 1 == depth)
            break; // nothing was scattered
        if (has(Step::TraceShadow)) {
            commands.dispatchIndirect(kernel(Step::TraceShadow), atBounce[b], pools.counts, shadowGroups(b), push);
            commands.barrier();
        }
    }
    for (std::uint32_t b = depth; b-- > 0;) {
        recordScan(commands, atBounce[b], pools, b, keepRecords);
        commands.barrier();
    }
    if (pass_.measure)
        perPath(kernel(Step::GatherMoments));
    if (pass_.measure && film)
        commands.barrier(); // nothing but the buffer that stands for missing ones is shared
    if (film)
        perPath(kernel(Step::GatherFilm)); // no pixel without a path is in an image
}

void Wavefront::recordScan(Commands& commands, Bindings bindings, const Pools& pools, std::uint32_t bounce, bool keepRecords) const {
    const std::uint32_t n = pools.capacity, depth = pools.needs.maxDepth;
    const bool last = bounce + 1 == depth;
    const std::uint64_t entries = pass_.mode == kModeReverse ? pools.gradients.size() / 8 : 1;
    const std::uint64_t slice = gradientSlice();
    for (std::uint64_t first = 0; first < entries; first += slice) {
        const std::uint64_t count = std::min(slice, entries - first);
        if (pass_.mode == kModeReverse)
            bindings.set(gpu::kBindGradients, pools.gradients, first * 8, count * 8);
        const auto scan = [&](Step step, std::uint32_t shadingClass, bool suffixes) {
            const bool all = shadingClass == gpu::kVertexClasses;
            const std::uint64_t groups = !all ? classGroups(bounce, shadingClass) : pass_.roulette ? vertexGroups(bounce) : arrivalGroups(bounce);
            commands.dispatchIndirect(kernel(step), bindings, pools.counts, groups,
                                      gpu::ScanPush{bounce, n, std::uint32_t(first), std::uint32_t(count), keepRecords, shadingClass, suffixes && first == 0, depth});
        };
        if (!has(Step::ScanUndifferentiated)) {
            scan(Step::Scan, gpu::kVertexClasses, true);
        } else if (features_.derivesSurfacesAlone(pass_)) {
            // One dispatch passes on what all vertices reflect; others, over the vertices of differentiated surfaces, add to the gradients. The last
            // vertices scatter nothing.
            if (first == 0)
                scan(Step::ScanUndifferentiated, gpu::kVertexClasses, true);
            for (const auto& [surfaces, features] : features_.classes)
                if (features.differentiated && !last)
                    scan(Step::Scan, std::uint32_t(surfaces), false);
        } else {
            scan(Step::ScanUndifferentiated, gpu::kClassEscaped, true);
            const auto scanSurfaces = [&](Step step, ShadingClass surfaces) {
                if (last)
                    commands.barrier(); // stands for the next bounce too, though nothing there is read
                scan(step, std::uint32_t(surfaces), true);
            };
            for (const auto& [surfaces, features] : features_.classes)
                scanSurfaces(features.differentiated ? Step::Scan : Step::ScanUndifferentiated, surfaces);
            if (has(Step::ShadeUnlit))
                scanSurfaces(Step::ScanUndifferentiated, ShadingClass::Unlit);
        }
    }
}

} // namespace cmpg
