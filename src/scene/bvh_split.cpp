// Binned surface-area heuristic (Wald 2007) over ranges of references; ranges are handed between threads through one queue.
#include "scene/bvh_split.h"

#include "shared/bvh_node.h"

#include <algorithm>
#include <array>
#include <bit>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace cmpg {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kFewBins = 8; // for ranges of at most kFewReferences: most of the nodes, where sweeping bins is most of the work
constexpr std::uint32_t kFewReferences = 12;
constexpr std::uint32_t kParallelRange = 8192; // smaller ranges are finished by the thread that met them
// Cost of a binary split relative to a leaf block's: measured; a node of four children is worth three splits.
constexpr float kSplitCost = 0.5f;

struct Range {
    std::uint32_t slot, begin, end, depth;
    Box box;
};

struct Bin {
    Box box;
    std::uint32_t count = 0;
};
using AxisBins = std::array<Bin, kBins>;

struct Choice {
    int axis = -1;
    std::uint32_t bin = 0; // first bin of the right side
    float cost = std::numeric_limits<float>::infinity();
    Box left, right;
};

// Twice the centre: saves a multiplication everywhere and stays exact.
glm::vec3 center(const Reference& r) { return r.low + r.high; }

// Maps centres to bins. Written once, so that counting and partitioning cannot disagree.
struct Binning {
    glm::vec3 origin, scale;
    std::uint32_t bins;

    Binning(const Box& centers, std::uint32_t references)
        : origin(centers.low), bins(references <= kFewReferences ? kFewBins : kBins) {
        for (int a = 0; a < 3; ++a) {
            const float extent = centers.high[a] - centers.low[a];
            const float s = float(bins) * 0.9999f / extent;
            scale[a] = extent > 0 && s < std::numeric_limits<float>::infinity() ? s : 0.f;
        }
    }
    std::uint32_t bin(glm::vec3 c, int axis) const {
        return std::min(std::uint32_t((c[axis] - origin[axis]) * scale[axis]), bins - 1);
    }
};

class Splitter {
  public:
    Splitter(std::vector<Reference>& references, SplitTree& tree) : references_(references), tree_(tree) {}

    void run(const Range& root, unsigned threads) {
        queue_.push_back(root);
        std::vector<std::thread> workers;
        for (unsigned i = 1; i < threads; ++i)
            workers.emplace_back([this] { work(); });
        work();
        for (std::thread& w : workers)
            w.join();
    }

  private:
    void work() {
        std::unique_lock lock(mutex_);
        for (;;) {
            ready_.wait(lock, [this] { return !queue_.empty() || busy_ == 0; });
            if (queue_.empty())
                return;
            const Range range = queue_.back();
            queue_.pop_back();
            ++busy_;
            lock.unlock();
            split(range);
            lock.lock();
            if (--busy_ == 0 && queue_.empty())
                ready_.notify_all();
        }
    }

    void share(const Range& range) {
        {
            const std::lock_guard lock(mutex_);
            queue_.push_back(range);
        }
        ready_.notify_one();
    }

    // Splits a range that is too large or too costly for a leaf, and all below it.
    void split(Range range) {
        for (;;) {
            SplitNode& node = tree_.slots[range.slot];
            Range left, right;
            divide(range, left, right);
            node.left = left.box;
            node.right = right.box;
            node.middle = left.end;
            node.leftLeaf = isLeaf(left);
            node.rightLeaf = isLeaf(right);
            if (!node.leftLeaf && !node.rightLeaf) {
                if (right.end - right.begin >= kParallelRange && left.end - left.begin >= kParallelRange)
                    share(right);
                else
                    split(right);
                range = left;
            } else if (!node.leftLeaf) {
                range = left;
            } else if (!node.rightLeaf) {
                range = right;
            } else {
                return;
            }
        }
    }

    // A leaf where it may be one and the best split would not be cheaper.
    bool isLeaf(const Range& r) const {
        const std::uint32_t n = r.end - r.begin;
        if (n == 1)
            return true;
        if (n > gpu::kMaxLeafBlocks)
            return false;
        const Choice best = choose(r);
        const float area = r.box.halfArea();
        return best.axis < 0 || kSplitCost * area + best.cost >= float(n) * area;
    }

    Box centerBox(const Range& r) const {
        Box box;
        for (std::uint32_t i = r.begin; i < r.end; ++i)
            box.grow(center(references_[i]));
        return box;
    }

    Choice choose(const Range& r) const {
        const Binning binning(centerBox(r), r.end - r.begin);
        std::array<AxisBins, 3> bins;
        for (std::uint32_t i = r.begin; i < r.end; ++i) {
            const Reference& ref = references_[i];
            const glm::vec3 c = center(ref);
            for (int axis = 0; axis < 3; ++axis) {
                Bin& b = bins[axis][binning.bin(c, axis)];
                b.box.grow({ref.low, ref.high});
                ++b.count;
            }
        }
        Choice best;
        for (int axis = 0; axis < 3; ++axis)
            if (binning.scale[axis] > 0)
                sweep(bins[axis], binning.bins, axis, best);
        return best;
    }

    // Cost of splitting before each bin: area times references, summed over both sides.
    static void sweep(const AxisBins& bins, std::uint32_t count, int axis, Choice& best) {
        std::array<Box, kBins> rightBox;
        std::array<std::uint32_t, kBins> rightCount;
        Box box;
        std::uint32_t inside = 0;
        for (std::uint32_t b = count; b-- > 1;) {
            if (bins[b].count > 0) {
                box.grow(bins[b].box);
                inside += bins[b].count;
            }
            rightBox[b] = box;
            rightCount[b] = inside;
        }
        box = {};
        inside = 0;
        for (std::uint32_t b = 1; b < count; ++b) {
            if (bins[b - 1].count == 0)
                continue; // the same split as before this bin
            box.grow(bins[b - 1].box);
            inside += bins[b - 1].count;
            if (rightCount[b] == 0)
                break;
            const float cost = box.halfArea() * float(inside) + rightBox[b].halfArea() * float(rightCount[b]);
            if (cost < best.cost)
                best = {axis, b, cost, box, rightBox[b]};
        }
    }

    void divide(const Range& r, Range& left, Range& right) {
        const auto first = references_.begin();
        std::uint32_t middle = r.begin;
        Choice best;
        // Below this depth halving would still reach leaves in time; beyond it only halving is safe.
        const std::uint32_t n = r.end - r.begin;
        if (r.depth + std::bit_width(n) < gpu::kMaxBvhDepth)
            best = choose(r);
        if (best.axis >= 0) {
            const Binning binning(centerBox(r), r.end - r.begin);
            const auto isLeft = [&](const Reference& x) { return binning.bin(center(x), best.axis) < best.bin; };
            middle = std::uint32_t(std::partition(first + r.begin, first + r.end, isLeft) - first);
            left.box = best.left;
            right.box = best.right;
        } else {
            // All centres coincide (or the tree is too deep): any halves do.
            middle = r.begin + n / 2;
            for (std::uint32_t i = r.begin; i < r.end; ++i)
                (i < middle ? left : right).box.grow({references_[i].low, references_[i].high});
        }
        left = {r.slot + 1, r.begin, middle, r.depth + 1, left.box};
        right = {r.slot + (middle - r.begin), middle, r.end, r.depth + 1, right.box};
    }

    std::vector<Reference>& references_;
    SplitTree& tree_;
    std::mutex mutex_;
    std::condition_variable ready_;
    std::vector<Range> queue_;
    unsigned busy_ = 0;
};

} // namespace

SplitTree splitReferences(std::vector<Reference>& references, unsigned threads) {
    SplitTree tree;
    const std::uint32_t n = std::uint32_t(references.size());
    for (const Reference& r : references)
        tree.box.grow({r.low, r.high});
    tree.single = n <= 1;
    if (tree.single)
        return tree;
    tree.slots.resize(n);
    Splitter(references, tree).run({0, 0, n, 0, tree.box}, threads);
    return tree;
}

} // namespace cmpg
