// How the guide's tree follows new records: forget, add, split or join cells, refine quadtrees.
#include "base/error.h"
#include "base/parallel.h"
#include "guiding/field/quadtree.h"
#include "guiding/field/sd_tree.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace cmpg {
namespace {

constexpr std::size_t kGrain = 64;    // cells a thread takes at once
constexpr double kForgotten = 1e-200; // a smaller weight is none: quotients of denormal numbers are no means

// What cannot be a sum of records counts as nothing. The bound on means keeps whole trees far below SdTree::kMaxMean.
struct Clean {
    double most;
    double operator()(double sum) const { return sum > 0 && sum < most ? sum : 0; }
    GuideMass operator()(const GuideMass& m) const { return {(*this)(m.primal), (*this)(m.plus), (*this)(m.minus)}; }
};

void scale(GuideCell& cell, double factor) {
    for (QuadNode& node : cell.nodes)
        for (GuideMass& m : node.mass)
            m = m * factor;
    cell.records *= factor;
    cell.reflected *= factor;
    cell.derivative *= factor;
}

void add(GuideCell& cell, const CellRecords& records) {
    const Clean clean{1e24 * double(records.count)};
    for (std::size_t i = 0; i < cell.nodes.size(); ++i)
        for (std::uint32_t q = 0; q < 4; ++q)
            cell.nodes[i].mass[q] += clean(records.leaves[i][q]); // inner quadrants are summed anew
    cell.records += double(records.count);
    cell.reflected += clean(records.reflected);
    cell.derivative += clean(records.derivative);
}

// Both have the same quadtree, as all cells of a tree that knew nothing.
void join(GuideCell& cell, const GuideCell& other) {
    for (std::size_t i = 0; i < cell.nodes.size(); ++i)
        for (std::uint32_t q = 0; q < 4; ++q)
            cell.nodes[i].mass[q] += other.nodes[i].mass[q];
    cell.records += other.records;
    cell.reflected += other.reflected;
    cell.derivative += other.derivative;
}

// The cells of a tree while it changes, and what is new in each.
struct Cells {
    std::vector<SpatialNode>& spatial;
    std::vector<GuideCell>& cells;
    std::vector<double> fresh; // new records of each cell; fractions after splits
};

// Subtrees with at most `most` new records become one cell each. Nodes and cells are numbered anew, level by level.
void collapse(Cells& tree, double most) {
    std::vector<SpatialNode>& spatial = tree.spatial;
    std::vector<double> fresh(spatial.size());
    for (std::size_t i = spatial.size(); i-- > 0;) {
        SpatialNode& node = spatial[i];
        if (!node.child) {
            fresh[i] = tree.fresh[node.cell];
            continue;
        }
        fresh[i] = fresh[node.child] + fresh[node.child + 1];
        if (fresh[i] > most)
            continue;
        node.cell = spatial[node.child].cell; // both are leaves by now: they have no more than their parent
        join(tree.cells[node.cell], tree.cells[spatial[node.child + 1].cell]);
        node.child = 0;
    }
    std::vector<SpatialNode> nodes = {spatial[0]};
    std::vector<double> count = {fresh[0]};
    std::vector<GuideCell> cells;
    std::vector<double> cellCount;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (const std::uint32_t child = nodes[i].child) {
            nodes[i].child = std::uint32_t(nodes.size());
            nodes.insert(nodes.end(), {spatial[child], spatial[child + 1]});
            count.insert(count.end(), {fresh[child], fresh[child + 1]});
        } else {
            cells.push_back(std::move(tree.cells[nodes[i].cell]));
            cellCount.push_back(count[i]);
            nodes[i].cell = std::uint32_t(cells.size() - 1);
        }
    }
    spatial = std::move(nodes);
    tree.cells = std::move(cells);
    tree.fresh = std::move(cellCount);
}

// Halves cells with too many new records, all of one generation before their halves.
void split(Cells& tree, const SdTreeConfig& config, UpdateReport& report) {
    struct Leaf {
        std::uint32_t node, depth;
    };
    std::vector<Leaf> leaves(tree.cells.size()); // of each cell
    std::vector<std::uint32_t> depth(tree.spatial.size());
    for (std::uint32_t i = 0; i < tree.spatial.size(); ++i) {
        const SpatialNode& node = tree.spatial[i];
        if (node.child)
            depth[node.child] = depth[node.child + 1] = depth[i] + 1;
        else
            leaves[node.cell] = {i, depth[i]};
    }
    std::uint64_t total = 0;
    for (const GuideCell& cell : tree.cells)
        total += cell.nodes.size();

    std::deque<Leaf> queue(leaves.begin(), leaves.end());
    for (; !queue.empty(); queue.pop_front()) {
        const Leaf leaf = queue.front();
        const std::uint32_t left = tree.spatial[leaf.node].cell;
        if (tree.fresh[left] <= config.cellRecords || leaf.depth >= config.maxSpatialDepth)
            continue;
        if (total + tree.cells[left].nodes.size() > config.maxNodes) {
            ++report.refusedSplits;
            continue;
        }
        total += tree.cells[left].nodes.size();
        ++report.spatialSplits;
        scale(tree.cells[left], 0.5);
        tree.fresh[left] *= 0.5;
        GuideCell half = tree.cells[left];
        const double fresh = tree.fresh[left];
        const auto right = std::uint32_t(tree.cells.size());
        tree.cells.push_back(std::move(half));
        tree.fresh.push_back(fresh);
        const auto child = std::uint32_t(tree.spatial.size());
        tree.spatial.insert(tree.spatial.end(), {SpatialNode{0, left}, SpatialNode{0, right}});
        tree.spatial[leaf.node] = {child, 0};
        queue.insert(queue.end(), {Leaf{child, leaf.depth + 1}, Leaf{child + 1, leaf.depth + 1}});
    }
}

// Refines the quadtrees of cells that learnt something. What exists and stays is granted to all, growth in the order of the cells.
void refine(Cells& tree, const SdTreeConfig& config, bool all, UpdateReport& report) {
    const QuadRefinement rule{config.directionShare, config.maxQuadDepth};
    const auto touched = [&](std::size_t cell) { return all || tree.fresh[cell] > 0; };
    std::vector<QuadDemand> demands(tree.cells.size());
    parallelFor(tree.cells.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint64_t now = tree.cells[i].nodes.size();
            demands[i] = touched(i) ? demand(tree.cells[i].nodes, rule) : QuadDemand{now, now};
        }
    });
    std::uint64_t left = config.maxNodes;
    for (const QuadDemand& d : demands)
        left -= d.kept; // no more than there were
    std::vector<std::uint64_t> limits(tree.cells.size());
    for (std::size_t i = 0; i < demands.size(); ++i) {
        const std::uint64_t growth = std::min(demands[i].wanted - demands[i].kept, left);
        left -= growth;
        limits[i] = demands[i].kept + growth;
        report.refusedSplits += demands[i].wanted - limits[i];
    }
    parallelFor(tree.cells.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (touched(i))
                tree.cells[i].nodes = refined(tree.cells[i].nodes, rule, limits[i]);
    });
}

} // namespace

UpdateReport SdTree::update(std::span<const CellRecords> records, bool forget) {
    UpdateReport report;
    std::vector<const CellRecords*> byCell(cells_.size(), nullptr);
    for (const CellRecords& r : records) {
        if (r.cell >= cells_.size() || byCell[r.cell] || r.leaves.size() != cells_[r.cell].nodes.size())
            throw Error(ErrorKind::Numerical, "records of the guide's cell " + std::to_string(r.cell) + " do not fit the guide",
                        "they were made with another state of it");
        byCell[r.cell] = &r;
        report.records += r.count;
    }
    const bool first = empty();
    if (first && report.records == 0)
        return report; // learnt nothing: the next update is the first

    Cells tree{spatial_, cells_, std::vector<double>(cells_.size(), 0)};
    parallelFor(cells_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            GuideCell& cell = cells_[i];
            const bool known = cell.records > 0;
            if (!known)
                cell.faded = 1;
            else if (forget)
                cell.faded *= config_.forgetting;
            const bool forgotten = known && cell.weight() < kForgotten, learns = byCell[i] && byCell[i]->count > 0;
            if (forgotten)
                cell.faded = 0;
            if (forgotten || learns)
                scale(cell, std::exchange(cell.faded, 1.0));
            if (learns) {
                add(cell, *byCell[i]);
                tree.fresh[i] = double(byCell[i]->count);
                sumUp(cell.nodes);
            }
            cell.changed |= learns || forgotten;
        }
    });
    if (first) {
        collapse(tree, config_.cellRecords);
        for (GuideCell& cell : cells_)
            cell.changed = true;
    }
    split(tree, config_, report);
    refine(tree, config_, first, report);
    ++updates_;
    return report;
}

} // namespace cmpg
