// A measurement of trade-offs from its options to its files.
#include "lab/compare.h"

#include "base/log.h"
#include "lab/compare_report.h"
#include "lab/error_plot.h"
#include "lab/tradeoff_report.h"
#include "session/output.h"

#include <algorithm>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

// Of the whole time: passes of single settings and trainings, the reference; combinations get what is left.
constexpr double kSingleShare = 0.55, kReferenceShare = 0.2;
constexpr double kHorizon = 60; // seconds after which settings are compared
constexpr std::uint32_t kFewestPasses = 8; // of a setting: they have to show its variance
constexpr std::size_t kMostCombined = 4;   // knobs

// The mode follows from what is given; a target means steps of a recovery, whose images count.
Options tradeoffOptions(const Options& given) {
    Options o = given;
    o.mode = o.isReverse() ? "reverse" : "forward";
    o.reference = "auto";
    return o;
}

// What a training with a pass takes here, and what the defaults choose.
struct Probe {
    KnobUse use;
    double trainSeconds = 0; // wall, construction included
    double passSeconds = 0;
};

Probe probe(CompareSubject& subject, const Options& base) {
    const CompareMode mode = subject.modes.front();
    Probe found;
    const Stopwatch watch;
    MethodRenderer renderer(subject, {"defaults", base});
    renderer.train(mode, kReferenceTurn);
    found.trainSeconds = watch.seconds();
    found.passSeconds = renderer.pass(mode, kReferenceTurn).seconds;
    found.use.steps = subject.steps;
    found.use.reverse = mode == CompareMode::Reverse;
    found.use.roulette = renderer.last().roulette && found.use.reverse;
    found.use.guide = renderer.last().sampling != Sampling::Bsdf || found.use.roulette;
    return found;
}

TradeoffBudget budgetOf(const Options& options, const Probe& probe, std::size_t settings, double seconds, double reference) {
    TradeoffBudget budget;
    budget.turns = options.seeds.value_or(budget.turns);
    budget.passes = std::max(kFewestPasses, 2 * budget.turns);
    const double learning = probe.trainSeconds * budget.turns * double(settings);
    budget.seconds = std::max((seconds - learning) / double(settings), 0.01 * seconds / double(settings));
    budget.referenceSeconds = reference;
    return budget;
}

void write(const CompareSubject& subject, const TradeoffReport& found, const fs::path& folder, const Options& options, Report& report) {
    const ParetoPlot plot = tradeoffPlot(found);
    const std::pair<const char*, std::string> texts[] = {
        {"tradeoff.csv", tradeoffCsv(found)},
        {"tables.md", tradeoffMarkdown(found)},
        {"pareto.svg", plot.svg()},
        {"report.html", tradeoffDocument(subject, report.device, toConfig(options).dump(), found)}};
    for (const auto& [name, text] : texts) {
        writeTextFile(folder / name, text);
        report.outputs.emplace_back(fs::path(name).stem().string(), (folder / name).string());
    }
    writePng(folder / "pareto.png", plot.png());
    report.outputs.emplace_back("pareto_picture", (folder / "pareto.png").string());
    for (const auto& [name, image] : imagesOf(subject, subject.modes.front(), found.reference.reference.values)) {
        const fs::path file = folder / ("reference" + (name.empty() ? "" : "." + name) + ".exr");
        writeExr(file, image);
        report.outputs.emplace_back(file.stem().string(), file.string());
    }
    report.extra["table"] = tradeoffTable(found);
}

} // namespace

std::string tradeoff(const Options& options, Report& report, const ProgressText& progress) {
    constexpr float kHalfAnHour = 1800;
    const double allowed = double(options.time.value_or(kHalfAnHour));
    const Options base = tradeoffOptions(options);
    CompareSubject subject(base, report);
    subject.steps = !subject.targets.empty();
    beginComparison(subject, report);
    progress("training the defaults");
    const Probe probed = probe(subject, base);
    TradeoffReport found;
    found.horizon = kHorizon;
    const std::vector<Setting> singles = singleSettings(base, subject.session.host().maxDepth, probed.use, found.unused);
    TradeoffMeasurement measured =
        measureSettings(subject, singles, budgetOf(base, probed, singles.size(), kSingleShare * allowed, kReferenceShare * allowed), {}, report,
                        progress);
    found.singles = std::move(measured.results);
    found.reference = std::move(measured.reference);
    warnOfNoDerivative(found.reference);

    const std::vector<KnobChange> best = bestChanges(found.singles, kHorizon, kMostCombined);
    if (best.size() > 1) {
        std::vector<Setting> together{makeSetting(base, {})};
        for (const KnobChange& change : best)
            together.push_back(makeSetting(base, {change}));
        for (Setting& setting : combinedSettings(base, best))
            together.push_back(std::move(setting));
        subject.part = 1; // what was chosen for its luck with the first numbers would have the same luck again
        const double left = std::max(0.1 * allowed, allowed - report.elapsed());
        found.combined = measureSettings(subject, together, budgetOf(base, probed, together.size(), left, 0), found.reference.reference, report,
                                         progress)
                             .results;
    }
    found.seconds = report.elapsed();
    report.addDevice(subject.session.device());
    write(subject, found, options.output, base, report);
    report.warnOfLosses();
    return tradeoffMarkdown(found);
}

} // namespace cmpg
