// Guide files, and what one holds.
#include "base/error.h"
#include "guiding/field/density_map.h"
#include "guiding/guide_file.h"
#include "library/guide_point.h"
#include "library/guide_statistics.h"

#include <cmpg/guide.h>

namespace cmpg::v1 {

struct Guide::State {
    SdTree tree;
    std::vector<GuideCellFigures> cells;
    GuideFigures figures;
};

Guide Guide::load(const std::filesystem::path& file) {
    LoadedGuide loaded = loadGuide(file);
    std::vector<GuideCellFigures> cells = cellFigures(loaded.tree);
    GuideFigures figures = figuresOf(loaded.tree, cells);
    const GuideContext& context = loaded.context;
    figures.geometry = context.geometry;
    figures.parameters = context.parameters;
    for (const bool roulette : {false, true})
        for (const auto& [sampling, f] : roulette ? context.rouletteFigures : context.figures)
            figures.methods.push_back({sampling, roulette, f.variance, f.rays, f.passes});
    figures.reference = context.reference;
    Guide guide;
    guide.state_ = std::make_shared<const State>(std::move(loaded.tree), std::move(cells), std::move(figures));
    return guide;
}

const GuideFigures& Guide::figures() const { return state_->figures; }
const std::vector<GuideCellFigures>& Guide::cells() const { return state_->cells; }
std::string Guide::fault() const { return validateDensities(state_->tree); }

Image Guide::density(std::uint32_t cell, const std::array<double, 3>& mixture, int edge) const {
    const std::vector<GuideCell>& cells = state_->tree.cells();
    if (cell >= cells.size())
        throw Error(ErrorKind::Usage, "there is no cell " + std::to_string(cell), "the guide has cells 0 to " + std::to_string(cells.size() - 1), "");
    return densityOf(cells[cell], mixture, edge);
}

} // namespace cmpg::v1
