// Published guides without a device.
#include "guide_table.h"

#include "guiding/field/quadtree.h"
#include "guiding/field/quadtree_texels.h"
#include "guiding/field/spatial_words.h"
#include "guiding/samples.h"
#include "shared/guide.h"
#include "statistics.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace cmpg::test {
namespace {

glm::vec3 mean(const GuideMass& m, double records) {
    const auto one = [&](double sum) { return float(std::min(records > 0 ? sum / records : 0, 1e30)); };
    return {one(m.primal), one(m.plus), one(m.minus)};
}

GuideTable published(SdTree tree) {
    GuideTable table;
    table.lower = tree.lower();
    table.inverseExtent = 1.0f / (tree.upper() - tree.lower());
    table.spatial = spatialWords(tree.spatial());
    for (const GuideCell& cell : tree.cells()) {
        const auto root = std::uint32_t(table.nodes.size());
        table.cells.push_back({root, mean(cell.total(), cell.records)});
        for (const QuadNode& node : cell.nodes) {
            table.nodes.push_back(quadtreeTexel(node, root));
            for (std::size_t q = 0; q < 4; ++q) {
                table.masses.emplace_back(node.mass[q].primal, node.mass[q].plus, node.mass[q].minus);
                table.children.push_back(node.child[q] ? root + node.child[q] : 0);
            }
        }
    }
    const auto kept = std::make_shared<const SdTree>(std::move(tree));
    table.cellAt = [kept](glm::vec3 p) { return kept->cellAt(p); };
    return table;
}

} // namespace

GuideTable grownTable(std::uint32_t updates, std::uint32_t seed) {
    SdTreeConfig config;
    config.cellRecords = 500;
    SdTree tree({-1, -2, 0.5f}, {1, 2, 1.5f}, config);
    for (std::uint32_t i = 0; i < updates; ++i)
        tree.update(place(tree, randomSamples(tree.lower(), tree.upper(), 5000, 1000 * seed + i)));
    return published(std::move(tree));
}

GuideTable randomTable(std::uint32_t seed, double spread, std::uint32_t absent) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return double(random()) * 0x1p-32; };
    SdTreeConfig config;
    config.maxNodes = 1; // one cell
    SdTree tree({-1, -2, 0.5f}, {1, 2, 1.5f}, config);
    GuideCell& cell = tree.cells()[0];
    cell.records = 1;
    cell.nodes.assign(1, {});
    std::vector<std::uint32_t> depth{1};
    const double scale[3] = {spread * (2 * uniform() - 1), spread * (2 * uniform() - 1), spread * (2 * uniform() - 1)};
    for (std::size_t i = 0; i < cell.nodes.size(); ++i) {
        const std::uint32_t deep = random() % 4; // this quadrant goes on for sure
        for (std::uint32_t q = 0; q < 4; ++q) {
            const auto value = [&](int k) {
                const bool none = (absent >> k & 1) != 0 || random() % 4 == 0;
                return none ? 0 : std::pow(10, std::clamp(scale[k] + 3 * uniform(), -spread, spread - 3)); // 4^10 of them stay below
            };
            cell.nodes[i].mass[q] = {value(0), value(1), value(2)};
            if (depth[i] < gpu::kMaxQuadDepth && (q == deep || random() % 8 == 0)) {
                cell.nodes[i].child[q] = std::uint32_t(cell.nodes.size());
                cell.nodes.push_back({});
                depth.push_back(depth[i] + 1);
            }
        }
    }
    sumUp(cell.nodes);
    return published(std::move(tree));
}

double significance(const std::vector<double>& observed, const std::vector<double>& expected) { return chiSquareSignificance(observed, expected); }

} // namespace cmpg::test
