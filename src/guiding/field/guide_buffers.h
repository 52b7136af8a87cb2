// The guide in device memory: published means that kernels read, and integer sums that they add records to.
#pragma once

#include "guiding/field/sd_tree.h"
#include "shared/guide.h"
#include "vk/device.h"

namespace cmpg {

class Communicator;

// Every cell has a block of quadtree nodes in one array; its size is a power of two, and a cell keeps its block while its tree fits.
// Only cells that changed are uploaded, only cells that got records are read back.
class GuideBuffers {
  public:
    // `bytes`: device memory for the quadtrees with their sums.
    GuideBuffers(Device& device, std::uint64_t bytes);

    // Quadtree nodes that surely fit, whatever the cells' sizes: into so many bytes, and into these buffers, which the device may have bounded.
    static std::uint64_t nodesWithin(std::uint64_t bytes);
    std::uint64_t mostNodes() const { return capacity_ / 2; }

    void publish(SdTree& tree);
    void setInfo(const gpu::GuideInfo& info); // of the next pass
    void clear(); // before another tree is published: forgets blocks and records
    // Records of the passes of all ranks since the last call, whose units were 2^-k of these factors; the sums are zeroed.
    std::vector<CellRecords> collect(const SdTree& tree, double primalUnit, double derivativeUnit, Communicator& ranks);

    void bind(Bindings& bindings) const;

  private:
    struct Block {
        std::uint32_t first = 0, size = 0; // in nodes; size 0: none yet
    };
    Block allocate(std::uint32_t nodes);
    void release(Block block);
    void growTo(std::size_t words, std::size_t cells);
    // Consecutive nodes that cover the blocks: transfers are few, and may take some nodes between blocks along.
    std::vector<Block> runs(std::vector<Block> blocks) const;

    Device& device_;
    std::uint32_t capacity_ = 0; // nodes
    std::uint32_t used_ = 0;     // nodes handed out so far, freed blocks included
    std::vector<std::vector<std::uint32_t>> free_; // first nodes of free blocks, by log2 of their size
    std::vector<Block> blocks_;                    // by cell
    std::vector<double> inverseUnits_;             // of the published means, likewise
    std::vector<glm::uvec4> texels_;               // what nodes_ holds
    std::vector<gpu::GuideLeafSums> sums_;         // room to read records back into
    Buffer info_, spatial_, cells_, nodes_, leafSums_, cellSums_;
};

} // namespace cmpg
