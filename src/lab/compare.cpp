// A comparison from its options to its files.
#include "lab/compare.h"

#include "base/log.h"
#include "lab/compare_pictures.h"
#include "lab/compare_report.h"
#include "lab/error_plot.h"
#include "session/output.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

CompareBudget budgetOf(const Options& options) {
    CompareBudget budget;
    if (options.time)
        budget.seconds = double(*options.time);
    // Variance, and variance of the variance, need some passes however long one takes.
    budget.passes = options.seeds.value_or(options.time ? 4 : 16);
    if (options.referenceTime)
        budget.referenceSeconds = double(*options.referenceTime);
    return budget;
}

// A given reference of one gradient: the image, or one image per parameter in a folder, as the gradient command writes them.
Reference readReference(const CompareSubject& subject, CompareMode mode) {
    const fs::path path = subject.options.reference;
    const std::vector<double> zeros(mode == CompareMode::Forward ? std::size_t(3) * subject.view.width * subject.view.height
                                                                 : subject.parameterEntries());
    Reference reference;
    for (const auto& [name, shape] : imagesOf(subject, mode, zeros)) {
        const fs::path file = name.empty() ? path : path / (name + ".exr");
        const Image image = readImage(file).image;
        if (image.width != shape.width || image.height != shape.height)
            throw Error(ErrorKind::Input,
                        "reference " + file.string() + " is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                            ", the derivative " + std::to_string(shape.width) + " x " + std::to_string(shape.height),
                        "it was made for another parameter or image size", "make it with the gradient command and the same options");
        for (std::size_t p = 0; p < image.pixels(); ++p)
            for (int c = 0; c < shape.channels; ++c)
                reference.values.push_back(double(image.values[p * image.channels + std::min(c, image.channels - 1)]));
    }
    return reference;
}

void readTruth(CompareSubject& subject) {
    std::vector<double> values = readReference(subject, CompareMode::Optimize).values;
    auto next = values.begin();
    for (auto& truth : subject.truth) {
        std::copy(next, next + std::ptrdiff_t(truth.size()), truth.begin());
        next += std::ptrdiff_t(truth.size());
    }
}

ComparePart compareGradient(CompareSubject& subject, CompareMode mode, std::optional<Reference> given, Report& report, const ProgressText& progress) {
    std::vector<std::unique_ptr<MethodRenderer>> renderers;
    std::vector<Contestant> contestants;
    std::vector<MethodFacts> facts;
    for (const CompareMethod& method : subject.methods) {
        progress("training " + method.name);
        renderers.push_back(std::make_unique<MethodRenderer>(subject, method));
        MethodRenderer& renderer = *renderers.back();
        renderer.train(mode);
        facts.push_back({renderer.trainSeconds(), describeDecision(method, renderer.last())});
        contestants.push_back({method.name, [&renderer, mode](std::uint32_t index) { return renderer.pass(mode, index); }});
    }
    const std::size_t entries = mode == CompareMode::Forward ? std::size_t(3) * subject.view.width * subject.view.height
                                                             : subject.parameterEntries();
    const CompareBudget budget = budgetOf(subject.options);
    const GradientComparison comparison = compareGradients(contestants, entries, budget, std::move(given), progress);
    for (const GradientResult& result : comparison.results)
        report.seconds.gradient += result.seconds;
    report.seconds.gradient += comparison.reference.seconds;
    warnOfNoDerivative(comparison.reference);
    ComparePart part = gradientPart(subject, mode, comparison, facts);
    part.table.push_back({{"mode", compareModeName(mode)},
                          {"method", "reference"},
                          {"made_by", comparison.reference.madeBy},
                          {"passes", comparison.reference.passes},
                          {"seconds", comparison.reference.seconds},
                          {"relative_error", comparison.reference.reference.relativeError()}});
    return part;
}

ComparePart compareOptimisation(CompareSubject& subject, Report& report, const ProgressText& progress) {
    const OptimizeComparison comparison = compareOptimisations(subject, progress);
    for (const OptimizeResult& result : comparison.results)
        report.seconds.gradient += result.seconds - result.trainSeconds;
    return optimizePart(subject, comparison);
}

void writeParts(const CompareSubject& subject, const std::vector<ComparePart>& parts, const fs::path& folder, Report& report) {
    std::string results = kResultColumns, curves = kCurveColumns;
    auto& table = report.extra["table"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < parts.size(); ++i) {
        // A folder each, where there are several.
        const std::string mode = compareModeName(subject.modes[i]), prefix = parts.size() > 1 ? mode + "." : "";
        const fs::path place = parts.size() > 1 ? folder / mode : folder;
        requireWritableFolder(place);
        for (const auto& [name, image] : parts[i].images) {
            const fs::path file = place / (name + ".exr");
            writeExr(file, image);
            report.outputs.emplace_back(prefix + name, file.string());
        }
        // One picture of all, where there is one parameter: files that end in a parameter's name belong to several.
        if (parts[i].images.size() == parts[i].table.size() && subject.modes[i] != CompareMode::Optimize) {
            const fs::path strip = place / "estimates.png";
            writePng(strip, signedStrip(parts[i].images));
            report.outputs.emplace_back(prefix + "estimates", strip.string());
        }
        const fs::path plot = place / "error_over_time.svg";
        writeTextFile(plot, parts[i].svg);
        report.outputs.emplace_back(prefix + "plot", plot.string());
        results += parts[i].resultRows;
        curves += parts[i].curveRows;
        for (const auto& row : parts[i].table)
            table.push_back(row);
    }
    const std::pair<const char*, std::string> texts[] = {
        {"results.csv", results},
        {"error_over_time.csv", curves},
        {"report.html", compareDocument(subject, report.device, toConfig(subject.options).dump(), parts)}};
    for (const auto& [name, text] : texts) {
        writeTextFile(folder / name, text);
        report.outputs.emplace_back(fs::path(name).stem().string(), (folder / name).string());
    }
}

} // namespace

void compare(const Options& options, Report& report, const ProgressText& progress) {
    CompareSubject subject(options, report);
    std::optional<Reference> given;
    if (options.reference != "auto" && subject.modes.front() == CompareMode::Optimize)
        readTruth(subject);
    else if (options.reference != "auto")
        given = readReference(subject, subject.modes.front());
    beginComparison(subject, report);
    std::vector<ComparePart> parts;
    for (const CompareMode mode : subject.modes)
        parts.push_back(mode == CompareMode::Optimize ? compareOptimisation(subject, report, progress)
                                                      : compareGradient(subject, mode, given, report, progress));
    report.addDevice(subject.session.device());
    writeParts(subject, parts, options.output, report);
    report.warnOfLosses();
}

} // namespace cmpg
