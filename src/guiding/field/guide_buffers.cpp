// Publishing, reading back, and the blocks of nodes that make both cheap.
#include "guiding/field/guide_buffers.h"

#include "base/communicator.h"
#include "base/parallel.h"
#include "guiding/field/quadtree_texels.h"
#include "guiding/field/spatial_words.h"
#include "shared/bindings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace cmpg {
namespace {

constexpr std::uint64_t kNodeBytes = sizeof(glm::uvec4) + 4 * sizeof(gpu::GuideLeafSums);

// The inverse of a cell's typical mean, as a power of two: only ratios within a cell matter, and kernels compute with sizes about 1.
double inverseUnit(const GuideCell& cell) {
    const GuideMass m = cell.total();
    const double typical = std::max(m.primal, m.plus + m.minus) / (cell.records > 0 ? cell.records : 1);
    return typical > 0 ? std::ldexp(1.0, -std::ilogb(typical)) : 1;
}

// The means of a mass; what is too small to matter is nothing. `factor`: inverseUnit() over the records.
glm::vec3 mean(const GuideMass& m, double factor) {
    const auto one = [&](double sum) {
        const double v = sum * factor;
        return float(v > 1e-30 ? v : 0.0);
    };
    return {one(m.primal), one(m.plus), one(m.minus)};
}

std::int64_t integer(glm::uvec2 words) { return std::int64_t(std::uint64_t(words.y) << 32 | words.x); }

// Sums are 64-bit integers, two words each, the lower first: as the host's own.
static_assert(sizeof(gpu::GuideLeafSums) == 3 * 8 && sizeof(gpu::GuideCellSums) == 3 * 8 && std::endian::native == std::endian::little);

template <class Sums> void sumOverRanks(Communicator& ranks, std::vector<Sums>& sums) {
    if (ranks.size() == 1)
        return;
    std::vector<std::int64_t> integers(3 * sums.size());
    std::memcpy(integers.data(), sums.data(), 8 * integers.size());
    sumSparse(ranks, integers);
    std::memcpy(sums.data(), integers.data(), 8 * integers.size());
}

} // namespace

std::uint64_t GuideBuffers::nodesWithin(std::uint64_t bytes) {
    return bytes / kNodeBytes / 2; // a block may be half empty
}

GuideBuffers::GuideBuffers(Device& device, std::uint64_t bytes) : device_(device), free_(32) {
    const std::uint64_t byBinding = device.info().maxStorageBufferRange / (4 * sizeof(gpu::GuideLeafSums));
    const std::uint64_t byTexels = device.portable() ? device.info().maxStorageBufferRange / sizeof(glm::uvec4) : device.info().maxTexelBufferElements;
    constexpr std::uint64_t byWord = std::uint64_t(1) << (32 - gpu::kQuadChildBits);
    capacity_ = std::uint32_t(std::min({bytes / kNodeBytes, byBinding, byTexels, byWord}));
    info_ = Buffer(device, "guide info", sizeof(gpu::GuideInfo), MemoryKind::Guide);
    nodes_ = Buffer(device, "guide quadtrees", std::uint64_t(capacity_) * sizeof(glm::uvec4), MemoryKind::Guide, Texel::Rgba32ui);
    leafSums_ = Buffer(device, "guide records", std::uint64_t(capacity_) * 4 * sizeof(gpu::GuideLeafSums), MemoryKind::Guide);
}

GuideBuffers::Block GuideBuffers::allocate(std::uint32_t nodes) {
    const std::uint32_t size = std::bit_ceil(nodes);
    std::vector<std::uint32_t>& list = free_[std::size_t(std::countr_zero(size))];
    if (!list.empty()) {
        const Block block{list.back(), size};
        list.pop_back();
        return block;
    }
    if (capacity_ - used_ < size)
        return {};
    const Block block{used_, size};
    used_ += size;
    return block;
}

void GuideBuffers::release(Block block) {
    if (block.size)
        free_[std::size_t(std::countr_zero(block.size))].push_back(block.first);
}

void GuideBuffers::growTo(std::size_t words, std::size_t cells) {
    const auto reserve = [&](Buffer& buffer, const char* name, std::uint64_t bytes, Texel texel) {
        if (!buffer || buffer.size() < bytes)
            buffer = Buffer(device_, name, std::bit_ceil(std::max<std::uint64_t>(bytes, 4096)), MemoryKind::Guide, texel);
    };
    reserve(spatial_, "guide spatial tree", words * 4, Texel::R32ui);
    reserve(cells_, "guide cells", cells * sizeof(gpu::GpuGuideCell), Texel::Rgba32ui);
    reserve(cellSums_, "guide cell records", cells * sizeof(gpu::GuideCellSums), Texel::None);
}

std::vector<GuideBuffers::Block> GuideBuffers::runs(std::vector<Block> blocks) const {
    constexpr std::uint32_t kGap = 32; // nodes that cost less to take along than another transfer
    std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) { return a.first < b.first; });
    std::vector<Block> merged;
    for (const Block& b : blocks) {
        if (merged.empty() || b.first > merged.back().first + merged.back().size + kGap)
            merged.push_back(b);
        else
            merged.back().size = b.first + b.size - merged.back().first;
    }
    return merged;
}

void GuideBuffers::clear() {
    leafSums_.uploadAll(std::vector<gpu::GuideLeafSums>(std::size_t(used_) * 4));
    cellSums_.uploadAll(std::vector<gpu::GuideCellSums>(blocks_.size()));
    used_ = 0;
    for (auto& list : free_)
        list.clear();
    blocks_.clear();
}

void GuideBuffers::publish(SdTree& tree) {
    std::vector<GuideCell>& cells = tree.cells();
    const std::vector<std::uint32_t> spatial = spatialWords(tree.spatial());
    growTo(spatial.size(), cells.size());
    spatial_.uploadAll(spatial);

    for (std::size_t i = cells.size(); i < blocks_.size(); ++i)
        release(blocks_[i]);
    blocks_.resize(cells.size());
    inverseUnits_.resize(cells.size(), 1.0);
    std::vector<bool> move(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        move[i] = cells[i].nodes.size() > blocks_[i].size || std::bit_ceil(cells[i].nodes.size()) < blocks_[i].size;
        if (move[i])
            release(std::exchange(blocks_[i], Block{}));
    }
    // Largest first: freed blocks are only used again for their own size.
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < cells.size(); ++i)
        if (move[i])
            order.push_back(i);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return cells[a].nodes.size() > cells[b].nodes.size(); });
    for (const std::uint32_t i : order)
        blocks_[i] = allocate(std::uint32_t(cells[i].nodes.size()));
    if (std::any_of(order.begin(), order.end(), [&](auto i) { return blocks_[i].size == 0; })) {
        // Sizes have drifted apart from the free blocks: lay everything out anew, which nodesWithin() promises to fit.
        used_ = 0;
        for (auto& list : free_)
            list.clear();
        for (std::size_t i = 0; i < cells.size(); ++i) {
            blocks_[i] = allocate(std::uint32_t(cells[i].nodes.size()));
            cells[i].changed = true;
        }
    }

    texels_.resize(std::max<std::size_t>(texels_.size(), used_));
    std::vector<gpu::GpuGuideCell> table(cells.size());
    std::vector<Block> written(cells.size());
    parallelFor(cells.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            GuideCell& cell = cells[i];
            const Block block = blocks_[i];
            const double n = cell.records > 0 ? cell.records : 1;
            table[i].root = block.first;
            table[i].reflected = float(cell.reflected / n);
            table[i].derivative = float(cell.derivative / n);
            const bool rewrite = cell.changed || move[i];
            if (rewrite)
                inverseUnits_[i] = inverseUnit(cell);
            const double factor = inverseUnits_[i] / n;
            table[i].total = mean(cell.total(), factor);
            if (!rewrite)
                continue;
            glm::uvec4* texel = &texels_[block.first];
            for (const QuadNode& node : cell.nodes)
                *texel++ = quadtreeTexel(node, block.first);
            written[i] = {block.first, std::uint32_t(cell.nodes.size())};
            cell.changed = false;
        }
    });
    cells_.uploadAll(table);
    std::erase_if(written, [](const Block& b) { return b.size == 0; });
    for (const Block& run : runs(std::move(written)))
        nodes_.upload(std::as_bytes(std::span(texels_).subspan(run.first, run.size)),
                      std::uint64_t(run.first) * sizeof(glm::uvec4));
}

std::vector<CellRecords> GuideBuffers::collect(const SdTree& tree, double primalUnit, double derivativeUnit, Communicator& ranks) {
    const std::vector<GuideCell>& cells = tree.cells();
    auto cellSums = cellSums_.downloadAll<gpu::GuideCellSums>(cells.size());
    sumOverRanks(ranks, cellSums);
    std::vector<CellRecords> records;
    std::vector<Block> read;
    for (std::uint32_t i = 0; i < cells.size(); ++i)
        if (cellSums[i].count) {
            records.emplace_back();
            records.back().cell = i;
            read.push_back({blocks_[i].first, std::uint32_t(cells[i].nodes.size())});
        }
    sums_.resize(std::max<std::size_t>(sums_.size(), std::size_t(used_) * 4));
    const std::vector<gpu::GuideLeafSums> zeros(std::size_t(1) << 14);
    for (const Block& run : runs(std::move(read))) {
        constexpr std::uint64_t kLeaf = sizeof(gpu::GuideLeafSums);
        const std::size_t end = 4 * (std::size_t(run.first) + run.size);
        leafSums_.download(std::as_writable_bytes(std::span(sums_).subspan(4 * std::size_t(run.first), 4 * std::size_t(run.size))), 4 * kLeaf * run.first);
        for (std::size_t at = 4 * std::size_t(run.first); at < end; at += zeros.size())
            leafSums_.upload(std::as_bytes(std::span(zeros).first(std::min(zeros.size(), end - at))), kLeaf * at);
    }
    cellSums_.uploadAll(std::vector<gpu::GuideCellSums>(cells.size()));
    if (ranks.size() > 1) {
        std::vector<gpu::GuideLeafSums> all; // of the cells with records, one after the other
        const auto leavesOf = [&](const CellRecords& r) { return std::span(sums_).subspan(4 * std::size_t(blocks_[r.cell].first), 4 * cells[r.cell].nodes.size()); };
        for (const CellRecords& r : records)
            all.insert(all.end(), leavesOf(r).begin(), leavesOf(r).end());
        sumOverRanks(ranks, all);
        auto from = all.begin();
        for (const CellRecords& r : records) {
            const auto leaves = leavesOf(r);
            std::copy_n(from, leaves.size(), leaves.begin());
            from += std::ptrdiff_t(leaves.size());
        }
    }
    parallelFor(records.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            CellRecords& out = records[r];
            const gpu::GuideCellSums& c = cellSums[out.cell];
            out.count = c.count;
            out.reflected = double(integer(c.reflected)) * primalUnit;
            out.derivative = double(integer(c.derivative)) * derivativeUnit;
            out.leaves.resize(cells[out.cell].nodes.size());
            const gpu::GuideLeafSums* leaf = &sums_[std::size_t(blocks_[out.cell].first) * 4];
            for (std::array<GuideMass, 4>& node : out.leaves)
                for (GuideMass& mass : node) {
                    mass = {double(integer(leaf->primal)) * primalUnit, double(integer(leaf->plus)) * derivativeUnit,
                            double(integer(leaf->minus)) * derivativeUnit};
                    ++leaf;
                }
        }
    });
    return records;
}

void GuideBuffers::setInfo(const gpu::GuideInfo& info) { info_.upload(std::as_bytes(std::span(&info, 1))); }

void GuideBuffers::bind(Bindings& b) const {
    b.set(gpu::kBindGuideInfo, info_).set(gpu::kBindGuideSpatial, spatial_).set(gpu::kBindGuideCells, cells_).set(gpu::kBindGuideNodes, nodes_);
    b.set(gpu::kBindGuideLeafSums, leafSums_).set(gpu::kBindGuideCellSums, cellSums_);
}

} // namespace cmpg
