// The guide of a renderer: the tree, its copy on the device, and the units of the records between two updates.
#include "render/guide.h"

#include "base/error.h"

#include <limits>
#include <utility>

namespace cmpg {
namespace {

constexpr double kRecordBits = 24; // records have units of 2^-24 of a typical one, and 2^30 of room above it

SdTree emptyTree(const Scene& scene, const RenderConfig& config) {
    glm::vec3 lower(std::numeric_limits<float>::max()), upper(-lower);
    for (const glm::vec3& p : scene.geometry.positions) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    if (scene.geometry.positions.empty())
        lower = upper = glm::vec3(0);
    SdTreeConfig tree = config.guide;
    tree.maxNodes = GuideBuffers::nodesWithin(config.guideMemory);
    return SdTree(lower, upper, tree);
}

std::uint32_t kindOf(const FeatureSet::Pass& pass, Sampling kind) {
    if (!pass.guided || kind == Sampling::Bsdf)
        return gpu::kGuideNone;
    if (pass.mode == gpu::kModeRender || pass.mode == gpu::kModeDifference)
        return gpu::kGuidePrimal; // an image has no derivatives
    switch (kind) {
    case Sampling::Primal:
        return gpu::kGuidePrimal;
    case Sampling::Differential:
        return gpu::kGuideDifferential;
    case Sampling::Uniform:
        return gpu::kGuideUniform;
    case Sampling::Conditional:
        return gpu::kGuideConditional;
    case Sampling::Bsdf:
    case Sampling::Auto:
        break;
    }
    return gpu::kGuideNone;
}

} // namespace

Guide::Guide(Device& device, const Scene& scene, const RenderConfig& config)
    : tree(emptyTree(scene, config)), buffers(device, config.guideMemory), ranks_(config.ranks ? *config.ranks : oneRank()),
      mostNodes_(buffers.mostNodes()), emission_(std::any_of(config.differentiable.begin(), config.differentiable.end(), [&](std::uint32_t p) {
          return emitsLight(scene.parameters[p].kind);
      })), share_(config.guideShare), rouletteEffort_(config.rouletteEffort) {
    tree.limitNodes(std::min(tree.config().maxNodes, mostNodes_));
    buffers.publish(tree);
}

void Guide::beginPass(const FeatureSet::Pass& pass, const PassPlan& plan, std::uint32_t spp) {
    info_.lower = tree.lower();
    const glm::vec3 extent = tree.upper() - tree.lower();
    for (int c = 0; c < 3; ++c)
        info_.inverseExtent[c] = extent[c] > 0 ? 1 / extent[c] : 0;
    info_.kind = kindOf(pass, plan.method.kind);
    info_.share = share_;
    // Adjoints on the device come divided by the samples. 0: every path goes on once.
    info_.reference = plan.method.roulette && !tree.empty() ? float(rouletteEffort_ * plan.reference / spp) : 0.0f;
    buffers.setInfo(info_);
}

double Guide::meanRadiance() const {
    double sum = 0, records = 0;
    for (const GuideCell& c : tree.cells()) {
        sum += c.reflected * c.faded;
        records += c.weight();
    }
    return records > 0 ? sum / records : 0;
}

void Guide::setUnits(double radiance, double shortestNormal) {
    info_.primalScale = fixedPointScale(radiance, kRecordBits, primalUnit_);
    info_.derivativeScale = fixedPointScale(std::max(radiance / shortestNormal, emission_ ? 1.0 : 0.0), kRecordBits, derivativeUnit_);
    open_ = true;
}

UpdateReport Guide::update(bool forget) {
    if (!open_)
        return {};
    const std::vector<CellRecords> records = buffers.collect(tree, primalUnit_, derivativeUnit_, ranks_);
    const UpdateReport report = tree.update(records, std::exchange(valuesChanged_, false) || forget);
    open_ = false;
    published_ = false;
    return report;
}

void Guide::publish() {
    if (!published_)
        buffers.publish(tree);
    published_ = true;
}

void Guide::discardRecords() {
    if (open_)
        buffers.collect(tree, primalUnit_, derivativeUnit_, ranks_);
    open_ = false;
}

void Guide::replace(SdTree other) {
    if (other.nodes() > mostNodes_)
        throw Error(ErrorKind::Input, "the guide does not fit: it has " + std::to_string(other.nodes()) + " nodes",
                    "there is room for " + std::to_string(mostNodes_), "raise the memory budget of the guide", {"guide-memory"});
    other.limitNodes(tree.config().maxNodes); // what this run has memory for, not what that one had
    tree = std::move(other);
    for (GuideCell& cell : tree.cells())
        cell.changed = true;
    buffers.clear();
    buffers.publish(tree);
    open_ = false;
    published_ = true;
}

} // namespace cmpg
