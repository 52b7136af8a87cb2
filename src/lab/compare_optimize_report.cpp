// The optimisation part of a comparison's report.
#include "imaging/parameter_image.h"
#include "lab/compare_pictures.h"
#include "lab/compare_report.h"
#include "lab/error_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

std::string asGoodAfter(const OptimizeResult& r) {
    if (r.secondsToFirst.empty())
        return "&ndash;";
    const std::string runs = std::to_string(r.secondsToFirst.size()) + " of " + std::to_string(r.repetitions) + " runs";
    return shortNumber(median(r.secondsToFirst)) + " s" + (r.repetitions > 1 ? "<span class=\"how\">" + runs + "</span>" : "");
}

// What a step takes.
std::string samplesOf(const v1::RecoveryOptions& options) {
    const std::string image = std::to_string(options.spp) + " samples per pixel", derivative = std::to_string(options.sppGradient);
    if (options.sppDifference == 0)
        return "a step renders " + image + " and differentiates " + derivative;
    return "the first step renders " + image + ", further ones bring that image up to date with at most " + std::to_string(options.sppDifference) +
           ", and each differentiates " + derivative;
}

HtmlTable tableOf(const OptimizeComparison& comparison) {
    HtmlTable table;
    table.columns = {{"method", "What is compared; how it samples stands below"},
                     {"steps", "Updates of the parameters"},
                     {"seconds", "Of all steps, learning included"},
                     {"of it learning", "Seconds of rebuilding the guide"},
                     {"parameter MSE", "Mean squared error of the parameters at the end"},
                     {"ratio", "Error of the first method over this one's"},
                     {"as good as the first after", "Seconds to reach the first method's final error; of several runs the median of those that do, each beside the first method's run with the same seed"},
                     {"image MSE", "Of the recovered scene's image against the target, both with their own noise"}};
    for (std::size_t i = 0; i < comparison.results.size(); ++i) {
        const OptimizeResult& r = comparison.results[i];
        table.rows.push_back({methodCell(i, r.method, r.chosen),
                              shortNumber(r.steps), shortNumber(r.seconds), r.trainSeconds > 0 ? shortNumber(r.trainSeconds) : "&ndash;",
                              withError(r.parameterError.value, r.parameterError.error),
                              withError(r.ratio.value, r.ratio.error) + "&nbsp;&times;",
                              asGoodAfter(r),
                              withError(r.imageError.value, r.imageError.error)});
    }
    return table;
}

std::string recoveredFigures(const CompareSubject& subject, const OptimizeComparison& comparison) {
    std::string html;
    for (std::size_t k = 0; k < std::min(subject.session.parameters.size(), kMostPictured); ++k) {
        const Parameter& parameter = subject.session.parameter(k);
        const Image truth = parameterImage(parameter, subject.truth[k]);
        if (truth.pixels() < kFewestTexels)
            continue;
        std::vector<CaptionedImage> recovered{{truth, "what is to be found"}, {parameterImage(parameter, comparison.initial[k]), "the start"}};
        std::vector<CaptionedImage> errors;
        for (const OptimizeResult& r : comparison.results) {
            const Image image = parameterImage(parameter, r.values[k]);
            recovered.push_back({image, "<b>" + escapeHtml(r.method.name) + "</b>, MSE " + shortNumber(r.curve.back().error)});
            errors.push_back({difference(image, truth), "<b>" + escapeHtml(r.method.name) + "</b>"});
        }
        html += "<h3>" + escapeHtml(parameter.name) + ", recovered</h3>\n" +
                htmlFigures(plainFigures(recovered, parameter.highest() > 1)) + "<h3>Errors</h3>\n" + signedFigures(errors).html();
    }
    return html;
}

} // namespace

std::string headlineOf(const OptimizeComparison& comparison) {
    const auto& results = comparison.results;
    std::size_t best = 0;
    for (std::size_t i = 1; i < results.size(); ++i)
        if (results[i].parameterError.value < results[best].parameterError.value)
            best = i;
    if (best == 0)
        return results.size() > 1 ? "No other method recovers the parameters better than <b>" + escapeHtml(results.front().method.name) + "</b> here."
                                  : "";
    const OptimizeResult& r = results[best];
    std::string text = "<b>" + escapeHtml(r.method.name) + "</b> ends with 1/" + withError(r.ratio.value, r.ratio.error) + " of the error of <b>" +
                       escapeHtml(results.front().method.name) + "</b>";
    if (r.secondsToFirst.empty())
        return text + ".";
    if (r.secondsToFirst.size() < r.repetitions)
        text += ", and in " + std::to_string(r.secondsToFirst.size()) + " of " + std::to_string(r.repetitions) + " runs is as good as that after ";
    else
        text += ", and is as good as that after ";
    return text + shortNumber(median(r.secondsToFirst)) + " of its " + shortNumber(r.seconds) + " seconds.";
}

ComparePart optimizePart(const CompareSubject& subject, const OptimizeComparison& comparison) {
    ComparePart part;
    ErrorPlot plot;
    plot.title = "Error of the recovered parameters";
    plot.vertical = "mean squared error";
    for (const OptimizeResult& r : comparison.results) {
        ErrorCurve curve{r.method.name, {}};
        const std::string name = r.method.name;
        for (const CurvePoint& point : r.curve) {
            curve.points.emplace_back(point.seconds, point.error);
            part.curveRows += csvLine({"optimize", name, std::to_string(point.passes), csvNumber(point.seconds), csvNumber(point.error)});
        }
        plot.curves.push_back(std::move(curve));
        part.resultRows += csvLine({"optimize", name, csvNumber(r.steps), "", csvNumber(r.seconds), csvNumber(r.trainSeconds),
                                    csvNumber(r.parameterError.value), "", "", "", "", "", "", "", csvNumber(r.ratio.value),
                                    csvNumber(r.ratio.error), csvNumber(r.imageError.value), r.chosen});
        part.table.push_back({{"mode", "optimize"},
                              {"method", name},
                              {"steps", r.steps},
                              {"repetitions", r.repetitions},
                              {"seconds", r.seconds},
                              {"train_seconds", r.trainSeconds},
                              {"initial_mse", comparison.initialError},
                              {"mse", r.parameterError.value},
                              {"mse_error", r.parameterError.error},
                              {"ratio", r.ratio.value},
                              {"ratio_error", r.ratio.error},
                              {"image_mse", r.imageError.value},
                              {"chosen", r.chosen}});
        std::vector<double> values;
        for (const auto& parameter : r.values)
            values.insert(values.end(), parameter.begin(), parameter.end());
        for (auto& [suffix, image] : imagesOf(subject, CompareMode::Optimize, values))
            part.images.emplace_back(suffix.empty() ? name : name + "." + suffix, std::move(image));
    }
    part.svg = plot.svg();

    const std::string budget = subject.options.time ? shortNumber(double(*subject.options.time)) + " seconds for each method, everything counted"
                                                    : std::to_string(comparison.steps) + " steps for each method";
    const std::uint32_t repetitions = comparison.results.front().repetitions;
    part.html = "<section>\n<h2>Recovery of <code>" + escapeHtml(subject.parameterNames()) +
                "</code> from a picture</h2>\n<p class=\"lead\">From a wrong start, step by step, towards values with which the scene&rsquo;s image matches the target: " +
                budget + "; " + samplesOf(comparison.options) + ". The error before the first step is " + shortNumber(comparison.initialError) + ".</p>\n";
    const std::string result = headlineOf(comparison);
    if (!result.empty())
        part.html += "<p class=\"result\">" + result + "</p>\n";
    std::vector<CaptionedImage> pictures;
    for (const v1::Target& target : subject.targets)
        pictures.push_back({target.image, !pictures.empty() ? "a further target" : subject.targets.size() > 1 ? "the first of the targets" : "the target"});
    pictures.push_back({subject.picture, "the scene at the start"});
    part.html += htmlFigures(plainFigures(pictures, true));
    part.html += "<h3>Error over time</h3>\n<div class=\"plot\">" + svgImage(part.svg) + "</div>\n" + htmlTable(tableOf(comparison)) +
                 recoveredFigures(subject, comparison) +
                 "<details><summary>How to read this</summary>\n<p>The right values are known, so the error is that of the recovered values "
                 "themselves, not of an image. Methods take turns, step by step. Learning and rebuilding of guides count; compilation does not. " +
                 std::string(repetitions > 1 ? "Figures are means of " + std::to_string(repetitions) +
                                                   " runs with different random numbers, &plusmn; the standard error; curve and pictures are the first&rsquo;s."
                                             : "It is one run: other random numbers would move the figures somewhat.") +
                 " The image error holds the noise of the target and of the final rendering.</p></details>\n</section>\n";
    return part;
}

} // namespace cmpg
