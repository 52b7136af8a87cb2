// guide: what a saved guide holds, whether it holds together, and what one of its cells looks like.
#include "app/commands.h"
#include "imaging/guide_maps.h"
#include "session/exit_status.h"
#include "session/output.h"

#include <cmpg/guide.h>

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
v1::Guide load(const Options& options) {
    try {
        return v1::Guide::load(options.input);
    } catch (const Error& error) {
        std::error_code ignored;
        if (options.validateGuide && error.kind == ErrorKind::Input && fs::is_regular_file(options.input, ignored))
            throw CheckFailed(error);
        throw;
    }
}

void printLine(std::ostream& out, const char* format, auto... values) {
    char line[400];
    std::snprintf(line, sizeof line, format, values...);
    out << line << '\n';
}

std::string hexadecimal(std::uint64_t hash) {
    char text[24];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

void printFigures(std::ostream& out, const GuideFigures& f) {
    printLine(out, "box:         (%g, %g, %g) to (%g, %g, %g)", f.lower[0], f.lower[1], f.lower[2], f.upper[0], f.upper[1], f.upper[2]);
    printLine(out, "cells:       %zu, depth %u, mean %.2f", f.cells, f.spatialDepth, f.meanSpatialDepth);
    printLine(out, "nodes:       %llu of at most %llu, depth %u, mean of leaves %.2f", static_cast<unsigned long long>(f.nodes),
              static_cast<unsigned long long>(f.mostNodes), f.quadDepth, f.meanQuadDepth);
    printLine(out, "records:     %.6g in %u updates, faded by %g when parameters change", f.records, f.updates, f.forgetting);
    printLine(out, "mass:        P %.6g, D+ %.6g, D- %.6g", f.mass[0], f.mass[1], f.mass[2]);
    printLine(out, "cells that know no light: %.2f %%, no derivatives: %.2f %%", 100 * f.withoutRecords, 100 * f.withoutDerivative);
    out << "geometry:    " << hexadecimal(f.geometry) << '\n';
    for (const std::string& name : f.parameters)
        out << "parameter:   " << name << '\n';
    if (f.methods.empty())
        return;
    out << "measured:    variance, rays per path, passes\n";
    for (const MethodFigures& m : f.methods)
        printLine(out, "  %-13s%-10s%12.5g %8.3f %6u", nameOf(m.sampling, kSamplings), m.roulette ? "roulette" : "", m.variance, m.raysPerPath, m.passes);
}

// One line per cell under a line of names.
void printCells(std::ostream& out, const std::vector<GuideCellFigures>& cells) {
    out << "cell,depth,records,nodes,quad_depth,primal,plus,minus,reflected,derivative,lower_x,lower_y,lower_z,upper_x,upper_y,upper_z\n";
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const GuideCellFigures& c = cells[i];
        printLine(out, "%zu,%u,%.9g,%llu,%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", i, c.depth, c.records,
                  static_cast<unsigned long long>(c.nodes), c.quadDepth, c.means[0], c.means[1], c.means[2], c.reflected, c.derivative, c.lower[0], c.lower[1],
                  c.lower[2], c.upper[0], c.upper[1], c.upper[2]);
    }
}

nlohmann::ordered_json toJson(const GuideFigures& f) {
    auto plain = nlohmann::ordered_json::object(), with = plain;
    for (const MethodFigures& m : f.methods)
        (m.roulette ? with : plain)[nameOf(m.sampling, kSamplings)] = {{"variance", m.variance}, {"rays", m.raysPerPath}, {"passes", m.passes}};
    return {{"cells", f.cells},
            {"nodes", f.nodes},
            {"max_nodes", f.mostNodes},
            {"updates", f.updates},
            {"spatial_depth", {{"max", f.spatialDepth}, {"mean", f.meanSpatialDepth}}},
            {"quad_depth", {{"max", f.quadDepth}, {"mean", f.meanQuadDepth}}},
            {"records", f.records},
            {"mass", {{"primal", f.mass[0]}, {"plus", f.mass[1]}, {"minus", f.mass[2]}}},
            {"share_without_records", f.withoutRecords},
            {"share_without_derivative", f.withoutDerivative},
            {"most_records", f.mostRecords},
            {"geometry", hexadecimal(f.geometry)},
            {"parameters", f.parameters},
            {"figures", plain},
            {"roulette_figures", with},
            {"reference", f.reference}};
}

} // namespace

ExitStatus runGuide(const Options& options, Report& report) {
    const Weights weights = parseWeights(options.weights);
    const v1::Guide guide = load(options);
    const GuideFigures& figures = guide.figures();
    const std::vector<GuideCellFigures>& cells = guide.cells();
    const std::uint32_t chosen = options.cell.value_or(figures.mostRecords);
    if (chosen >= cells.size())
        throw Error(ErrorKind::Usage, "there is no cell " + std::to_string(chosen), "the guide has cells 0 to " + std::to_string(cells.size() - 1),
                    "--csv lists them");
    if (!options.output.empty())
        requireWritableFolder(options.output);

    std::ostream& out = textOut(options);
    report.extra["guide"] = toJson(figures);
    if (options.csv)
        printCells(out, cells);
    else
        printFigures(out, figures);
    if (!options.output.empty()) {
        const fs::path file = fs::path(options.output) / ("cell" + std::to_string(chosen) + ".png");
        writePng(file, drawCell({.number = chosen,
                                 .weight = cells[chosen].records,
                                 .means = cells[chosen].means,
                                 .weights = {weights.light, weights.derivative},
                                 .density = [&](const std::array<double, 3>& mixture, int edge) { return guide.density(chosen, mixture, edge); }}));
        report.outputs.emplace_back("cell", file.string());
    }
    if (!options.validateGuide)
        return ExitStatus::Done;
    const std::string wrong = guide.fault();
    report.extra["guide"]["valid"] = wrong.empty();
    if (!wrong.empty())
        throw CheckFailed({ErrorKind::Input, options.input + " does not hold together: " + wrong, "it was made by something else",
                           "save the guide anew"});
    if (!options.csv)
        out << "valid:       yes\n";
    return ExitStatus::Done;
}

} // namespace cmpg
