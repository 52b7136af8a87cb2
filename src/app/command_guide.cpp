// guide: what a saved guide holds, whether it holds together, and what one of its cells looks like.
#include "app/commands.h"
#include "guiding/field/density_map.h"
#include "guiding/guide_file.h"
#include "imaging/guide_maps.h"
#include "lab/guide_statistics.h"
#include "session/exit_status.h"
#include "session/output.h"

#include <cmath>
#include <ostream>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

struct Weights {
    double light = 1, derivative = 1;
};

Weights parseWeights(const std::string& text) {
    Weights w;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%lf,%lf%c", &w.light, &w.derivative, &rest) != 2 || !(w.light >= 0 && w.light <= 1e30) ||
        !(w.derivative >= 0 && w.derivative <= 1e30) || w.light + w.derivative == 0)
        throw Error(ErrorKind::Usage, "--weights takes two numbers from 0 to 1e30, not both 0, not '" + text + "'", "",
                    "the first weights light, the second its derivatives: --weights 1,0.5");
    return w;
}

// A damaged guide is what --validate looks for, not a mistake of its user.
LoadedGuide load(const Options& options) {
    try {
        return loadGuide(options.input);
    } catch (const Error& error) {
        std::error_code ignored;
        if (options.validateGuide && error.kind == ErrorKind::Input && fs::is_regular_file(options.input, ignored))
            throw CheckFailed(error);
        throw;
    }
}

void printLine(std::ostream& out, const char* format, auto... values) {
    char line[256];
    std::snprintf(line, sizeof line, format, values...);
    out << line << '\n';
}

void printFigures(std::ostream& out, const GuideFigures& f, const SdTree& tree) {
    const glm::vec3 lower = tree.lower(), upper = tree.upper();
    printLine(out, "box:         (%g, %g, %g) to (%g, %g, %g)", double(lower.x), double(lower.y), double(lower.z), double(upper.x),
              double(upper.y), double(upper.z));
    printLine(out, "cells:       %zu, depth %u, mean %.2f", f.cells, f.spatialDepth, f.meanSpatialDepth);
    printLine(out, "nodes:       %llu of at most %llu, depth %u, mean of leaves %.2f", static_cast<unsigned long long>(f.nodes),
              static_cast<unsigned long long>(tree.config().maxNodes), f.quadDepth, f.meanQuadDepth);
    printLine(out, "records:     %.6g in %u updates, faded by %g in each", f.records, tree.updates(), tree.config().forgetting);
    printLine(out, "mass:        P %.6g, D+ %.6g, D- %.6g", f.mass.primal, f.mass.plus, f.mass.minus);
    printLine(out, "cells that know no light: %.2f %%, no derivatives: %.2f %%", 100 * f.withoutRecords, 100 * f.withoutDerivative);
}

void printContext(std::ostream& out, const GuideContext& context) {
    printLine(out, "geometry:    %016llx", static_cast<unsigned long long>(context.geometry));
    for (const std::string& name : context.parameters)
        out << "parameter:   " << name << '\n';
    if (context.figures.empty() && context.rouletteFigures.empty())
        return;
    out << "measured:    variance, rays per path, passes\n";
    for (const bool roulette : {false, true})
        for (const auto& [kind, f] : roulette ? context.rouletteFigures : context.figures)
            printLine(out, "  %-13s%-10s%12.5g %8.3f %6u", nameOf(kind, kSamplings), roulette ? "roulette" : "", f.variance, f.rays, f.passes);
}

nlohmann::ordered_json figuresJson(const std::map<Sampling, SamplingFigures>& figures) {
    auto json = nlohmann::ordered_json::object();
    for (const auto& [kind, f] : figures)
        json[nameOf(kind, kSamplings)] = {{"variance", f.variance}, {"rays", f.rays}, {"passes", f.passes}};
    return json;
}

nlohmann::ordered_json toJson(const GuideFigures& f, const LoadedGuide& guide) {
    char hash[24];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(guide.context.geometry));
    return {{"cells", f.cells},
            {"nodes", f.nodes},
            {"max_nodes", guide.tree.config().maxNodes},
            {"updates", guide.tree.updates()},
            {"spatial_depth", {{"max", f.spatialDepth}, {"mean", f.meanSpatialDepth}}},
            {"quad_depth", {{"max", f.quadDepth}, {"mean", f.meanQuadDepth}}},
            {"records", f.records},
            {"mass", {{"primal", f.mass.primal}, {"plus", f.mass.plus}, {"minus", f.mass.minus}}},
            {"share_without_records", f.withoutRecords},
            {"share_without_derivative", f.withoutDerivative},
            {"most_records", f.mostRecords},
            {"geometry", hash},
            {"parameters", guide.context.parameters},
            {"figures", figuresJson(guide.context.figures)},
            {"roulette_figures", figuresJson(guide.context.rouletteFigures)},
            {"reference", guide.context.reference}};
}

} // namespace

ExitStatus runGuide(const Options& options, Report& report) {
    const Weights weights = parseWeights(options.weights);
    const LoadedGuide guide = load(options);
    const std::vector<GuideCellFigures> cells = cellFigures(guide.tree);
    const GuideFigures figures = figuresOf(guide.tree, cells);
    const std::uint32_t chosen = options.cell.value_or(figures.mostRecords);
    if (chosen >= cells.size())
        throw Error(ErrorKind::Usage, "there is no cell " + std::to_string(chosen), "the guide has cells 0 to " + std::to_string(cells.size() - 1),
                    "--csv lists them");
    if (!options.output.empty())
        requireWritableFolder(options.output);

    std::ostream& out = textOut(options);
    report.extra["guide"] = toJson(figures, guide);
    if (options.csv) {
        out << cellTable(cells);
    } else {
        printFigures(out, figures, guide.tree);
        printContext(out, guide.context);
    }
    if (!options.output.empty()) {
        const fs::path file = fs::path(options.output) / ("cell" + std::to_string(chosen) + ".png");
        const GuideCell& cell = guide.tree.cells()[chosen];
        const GuideMass& mean = cells[chosen].mean;
        writePng(file, drawCell({.number = chosen,
                                 .weight = cell.weight(),
                                 .means = {mean.primal, mean.plus, mean.minus},
                                 .weights = {weights.light, weights.derivative},
                                 .density = [&](const std::array<double, 3>& mixture, int edge) { return densityMap(cell, mixture, edge); }}));
        report.outputs.emplace_back("cell", file.string());
    }
    if (!options.validateGuide)
        return ExitStatus::Done;
    const std::string wrong = validateDensities(guide.tree);
    report.extra["guide"]["valid"] = wrong.empty();
    if (!wrong.empty())
        throw CheckFailed({ErrorKind::Input, options.input + " does not hold together: " + wrong, "it was made by something else",
                           "save the guide anew"});
    if (!options.csv)
        out << "valid:       yes\n";
    return ExitStatus::Done;
}

} // namespace cmpg
