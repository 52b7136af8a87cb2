// Guide files, and what one holds.
#pragma once

#include <cmpg/image.h>
#include <cmpg/namespace.h>
#include <cmpg/report.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace cmpg {

// One cell of a guide. Means are per record.
struct GuideCellFigures {
    std::array<double, 3> lower = {}, upper = {}; // its box
    std::uint32_t depth = 0;                      // spatial levels above it
    std::uint32_t quadDepth = 0;                  // levels of its quadtree
    std::uint64_t nodes = 0;                      // of its quadtree
    double records = 0;                           // statistical weight: less than was recorded, as it fades
    std::array<double, 3> means = {};             // of P, light, and of D+ and D-, the positive and the negative terms of its derivatives
    double reflected = 0, derivative = 0;         // means
};

struct GuideFigures {
    std::array<double, 3> lower = {}, upper = {};     // the box of all cells
    std::size_t cells = 0;
    std::uint64_t nodes = 0, mostNodes = 0;           // of all quadtrees; the bound it was learned under
    std::uint32_t spatialDepth = 0, quadDepth = 0;    // greatest
    double meanSpatialDepth = 0, meanQuadDepth = 0;   // over cells; over all leaves of their quadtrees
    double records = 0;                               // sum over cells
    std::array<double, 3> mass = {};                  // of P, D+ and D-, sums over cells
    double withoutRecords = 0, withoutDerivative = 0; // shares of the cells
    std::uint32_t mostRecords = 0;                    // number of the cell that has them
    std::uint32_t updates = 0;                        // passes or steps that it has learned from
    double forgetting = 0;                            // what weights of old records are multiplied by when parameters change

    std::uint64_t geometry = 0;               // hash of the scene's triangles
    std::vector<std::string> parameters = {}; // that derivatives were asked for
    std::vector<MethodFigures> methods = {};  // of derivative passes
    double reference = 0;                     // expected derivative contribution of a path, per unit of mean |adjoint|: what roulette compares with
};

} // namespace cmpg

namespace cmpg::v1 {

// What saveGuide() of a renderer or a recovery has written. A handle: copies are the same guide.
class Guide {
  public:
    // Error(Input) on a file that is none, of another version, truncated, or whose contents contradict each other.
    static Guide load(const std::filesystem::path& file);

    const GuideFigures& figures() const;
    const std::vector<GuideCellFigures>& cells() const; // by number
    // What a cell would draw from, as GuidePoint::density. Error(Usage) where there is no such cell.
    Image density(std::uint32_t cell, const std::array<double, 3>& mixture, int edge) const;
    // What does not hold together although it could be read: a density that does not integrate to 1 in the single precision that the device reads. Else empty.
    std::string fault() const;

    struct State;

  private:
    Guide() = default; // of no file
    std::shared_ptr<const State> state_;
};

} // namespace cmpg::v1
