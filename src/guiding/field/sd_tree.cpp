// The guide's tree at rest: made, looked up, checked.
#include "guiding/field/sd_tree.h"

#include "guiding/field/quadtree.h"
#include "shared/guide.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::uint64_t regularNodes(std::uint32_t depth) {
    std::uint64_t count = 1;
    for (std::uint64_t width = 4; --depth > 0; width *= 4)
        count += width;
    return count;
}

bool isNumber(double value) { return std::isfinite(value) && value >= 0; }

} // namespace

GuideMass GuideCell::total() const { return cmpg::total(nodes[0]); }

SdTree::SdTree(glm::vec3 lower, glm::vec3 upper, const SdTreeConfig& config) : lower_(lower), upper_(upper), config_(config) {
    for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(lower[axis]) || !std::isfinite(upper[axis]) || lower[axis] > upper[axis])
            lower_[axis] = upper_[axis] = 0; // the box of nothing
    config_.maxNodes = std::max<std::uint64_t>(config_.maxNodes, 1);
    config_.maxQuadDepth = std::clamp(config_.maxQuadDepth, 1u, gpu::kMaxQuadDepth);
    config_.maxSpatialDepth = std::min(config_.maxSpatialDepth, gpu::kMaxSpatialDepth);

    std::uint32_t quadDepth = std::min(kScoutQuadDepth, config_.maxQuadDepth);
    while (quadDepth > 1 && regularNodes(quadDepth) > config_.maxNodes)
        --quadDepth;
    std::uint32_t depth = std::min(kScoutDepth, config_.maxSpatialDepth);
    while (depth > 0 && (regularNodes(quadDepth) << depth) > config_.maxNodes)
        --depth;

    const std::uint32_t cells = 1u << depth;
    spatial_.resize(2 * cells - 1); // level by level
    for (std::uint32_t i = 0; i < cells - 1; ++i)
        spatial_[i].child = 2 * i + 1;
    for (std::uint32_t i = 0; i < cells; ++i)
        spatial_[cells - 1 + i].cell = i;
    GuideCell cell;
    cell.nodes = regularQuadtree(quadDepth);
    cells_.assign(cells, cell);
}

std::uint64_t SdTree::nodes() const {
    std::uint64_t count = 0;
    for (const GuideCell& cell : cells_)
        count += cell.nodes.size();
    return count;
}

void SdTree::limitNodes(std::uint64_t most) { config_.maxNodes = std::max(nodes(), most); }

// The kernels' arithmetic to the bit: after the scaling all steps are exact.
std::uint32_t SdTree::cellAt(glm::vec3 position) const {
    glm::vec3 unit;
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = 1 / (upper_[axis] - lower_[axis]);
        const float u = std::isfinite(inverse) ? (position[axis] - lower_[axis]) * inverse : 0.0f;
        unit[axis] = u > 0 ? std::min(u, 1.0f) : 0.0f; // NaN: 0
    }
    std::uint32_t node = 0;
    for (int axis = 0; spatial_[node].child; axis = (axis + 1) % 3) {
        const float doubled = 2 * unit[axis];
        const bool right = doubled >= 1;
        unit[axis] = right ? doubled - 1 : doubled;
        node = spatial_[node].child + std::uint32_t(right);
    }
    return spatial_[node].cell;
}

std::string SdTree::validate() const {
    for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(lower_[axis]) || !std::isfinite(upper_[axis]) || lower_[axis] > upper_[axis])
            return "the box is inverted or not finite";
    if (spatial_.empty() || cells_.empty())
        return "there is no root";

    std::vector<std::uint32_t> depth(spatial_.size(), 0); // plus one; 0: not reached yet
    std::vector<bool> used(cells_.size(), false);
    depth[0] = 1;
    for (std::size_t i = 0; i < spatial_.size(); ++i) {
        const std::string name = "spatial node " + std::to_string(i);
        if (!depth[i])
            return name + " is nobody's child";
        if (depth[i] - 1 > config_.maxSpatialDepth)
            return name + " lies too deep";
        const auto [child, cell] = spatial_[i];
        if (!child) {
            if (cell >= cells_.size() || used[cell])
                return name + " has a cell that is out of range or another's";
            used[cell] = true;
            continue;
        }
        if (child <= i || child >= spatial_.size() - 1)
            return name + " has a child out of range";
        if (depth[child] || depth[child + 1])
            return "a child of " + name + " has two parents";
        depth[child] = depth[child + 1] = depth[i] + 1;
    }
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        const std::string name = "cell " + std::to_string(i);
        const GuideCell& cell = cells_[i];
        if (!used[i])
            return name + " is nobody's";
        if (!isNumber(cell.records) || !isNumber(cell.reflected) || !isNumber(cell.derivative))
            return name + " has a negative or non-finite sum";
        if (!isNumber(cell.faded) || cell.faded > 1)
            return name + " has faded by an impossible factor";
        if (const std::string wrong = validateQuadtree(cell.nodes, config_.maxQuadDepth); !wrong.empty())
            return name + ": " + wrong;
        const GuideMass all = cell.total();
        if (std::max({all.primal, all.plus, all.minus, cell.reflected, cell.derivative}) > kMaxMean * cell.records)
            return name + " has means beyond all bounds";
    }
    if (nodes() > config_.maxNodes)
        return "there are more nodes than allowed";
    return {};
}

} // namespace cmpg
