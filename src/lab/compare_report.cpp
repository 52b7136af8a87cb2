// The gradient parts of a comparison's report, and the page around all parts.
#include "lab/compare_report.h"

#include "base/log.h"
#include "imaging/parameter_image.h"
#include "lab/compare_pictures.h"
#include "lab/error_plot.h"
#include "scene/export_folder.h"

#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

std::string percent(double fraction) {
    char text[32];
    std::snprintf(text, sizeof text, "%+.2g&nbsp;%%", 100 * fraction);
    return std::isfinite(fraction) ? text : "&ndash;";
}

std::string biasCell(const Bias& bias) {
    if (!std::isfinite(bias.along))
        return "&ndash;";
    char text[96];
    std::snprintf(text, sizeof text, "%s <small>&plusmn;&nbsp;%.2g&nbsp;%%</small>", percent(bias.along).c_str(), 100 * bias.interval);
    const char* verdict = bias.verdict == Bias::Verdict::Biased           ? "<span class=\"how bad\">biased</span>"
                          : bias.verdict == Bias::Verdict::BelowReference ? "<span class=\"how\">below the reference&rsquo;s error</span>"
                                                                          : "<span class=\"how\">none seen</span>";
    return text + std::string(verdict);
}

HtmlTable gradientTable(const CompareSubject& subject, const GradientComparison& comparison, const std::vector<MethodFacts>& facts) {
    HtmlTable table;
    table.columns = {{"method", "What is compared; how it samples stands below"},
                     {"passes", "Independent estimates of the gradient that were averaged"},
                     {"spp", "Samples per pixel of all passes together"},
                     {"seconds", "Of all passes"},
                     {"training", "Seconds of learning before the passes; not part of anything else here"},
                     {"MSE", "Mean squared error of the average of all passes against the reference, less the expected error of the reference itself"},
                     {"rel. variance", "Of one pass: summed over all entries, over the squared length of the gradient"},
                     {"bias", "Along the reference, with the 95 % interval"},
                     {"efficiency", "1 / (relative variance x seconds of a pass): twice as much is the same error in half the time"},
                     {"ratio", "Of efficiencies, to the first method"}};
    const double pixels = double(subject.view.width) * subject.view.height;
    for (std::size_t i = 0; i < comparison.results.size(); ++i) {
        const GradientResult& r = comparison.results[i];
        table.rows.push_back({methodCell(i, subject.methods[i], facts[i].chosen),
                              std::to_string(r.statistics.passes()), shortNumber(double(r.paths) / pixels), shortNumber(r.seconds),
                              facts[i].trainSeconds > 0 ? shortNumber(facts[i].trainSeconds) : "&ndash;", shortNumber(r.mse),
                              withError(r.relativeVariance.value, r.relativeVariance.error), biasCell(r.bias),
                              withError(r.efficiency.value, r.efficiency.error), withError(r.ratio.value, r.ratio.error) + "&nbsp;&times;"});
    }
    return table;
}

std::string referenceNote(const MeasuredReference& made) {
    const std::string error = shortNumber(made.reference.relativeError());
    if (made.madeBy.empty())
        return "The reference was given as a file. What error it has is not known, and nothing below that error can be told.";
    return "The reference is the mean of " + std::to_string(made.passes) + " further passes of <b>" + escapeHtml(made.madeBy) +
           "</b>, the most efficient method, with random numbers of their own (" + shortNumber(made.seconds) +
           " s). Its squared standard error is " + error +
           " of the squared length of the gradient. A bias that this method alone has would show as a bias of all others.";
}

std::string explanation(const GradientComparison& comparison) {
    return "<details><summary>How to read this</summary>\n"
           "<p>Every pass of a method is an independent estimate of the same derivative; passes are averaged, and methods take turns, so that "
           "whatever else the machine does hits all alike. The error falls with the square root of the time for each of them, so the plot "
           "shows parallel lines; how far to the left a line lies is how much less time the method needs. <b>Efficiency</b> puts that into a "
           "number: 1 / (relative variance &times; seconds of a pass). Numbers after &plusmn; are one standard error, but those of the bias "
           "are 95&nbsp;% intervals. Every method has learned once: the errors are those of passes by the one guide that came of it, and another "
           "training (<code>--seed</code>) may differ by more. Rare bright samples make all of these optimistic for as long as none of them has occurred.</p>\n"
           "<p><b>Bias</b> is the length of the mean error along the reference, as a share of the reference, with the interval by "
           "Student&rsquo;s t from batches of passes, the reference&rsquo;s own spread included; one honest interval in twenty leaves out 0. "
           "A method is called biased where 0 is left out at the level 99.9&nbsp;% (99.999&nbsp;% of fewer than 64 passes, which may all miss what is "
           "rare and bright), or where the mean error in any direction exceeds five of its standard errors (two-sample statistic of Chen and Qin 2010) "
           "and is larger than the error of the reference.</p>\n<p>" +
           referenceNote(comparison.reference) + "</p></details>\n";
}

std::string subjectFigures(const CompareSubject& subject, CompareMode mode) {
    std::vector<CaptionedImage> pictures{{subject.picture, "the scene as it is set"}};
    if (!subject.targets.empty())
        pictures.insert(pictures.begin(), {subject.targets.front().image, "the target"});
    std::vector<HtmlFigure> figures = plainFigures(pictures, true);
    if (mode == CompareMode::Forward)
        return htmlFigures(figures);
    const SignedFigures adjoint = signedFigures({{subject.adjoint, "the adjoint: what each pixel is worth"}});
    figures.push_back(adjoint.figures.front());
    return htmlFigures(figures) + adjoint.legend;
}

std::string estimateFigures(const CompareSubject& subject, CompareMode mode, const GradientComparison& comparison) {
    const auto reference = imagesOf(subject, mode, comparison.reference.reference.values);
    std::string html;
    for (std::size_t k = 0; k < std::min(reference.size(), kMostPictured); ++k) {
        const Image& right = reference[k].second;
        if (right.pixels() < kFewestTexels)
            continue;
        std::vector<CaptionedImage> estimates{{right, "reference"}}, differences;
        for (const GradientResult& r : comparison.results) {
            const Image image = imagesOf(subject, mode, r.statistics.mean())[k].second;
            estimates.push_back({image, "<b>" + escapeHtml(r.name) + "</b>, MSE " + shortNumber(r.mse)});
            differences.push_back({difference(image, right), "<b>" + escapeHtml(r.name) + "</b>"});
        }
        const std::string of = reference[k].first.empty() ? "" : " of " + escapeHtml(reference[k].first);
        html += "<h3>Estimates" + of + "</h3>\n" + signedFigures(estimates).html();
        html += "<h3>Their errors" + of + "</h3>\n" + signedFigures(differences).html();
    }
    return html;
}

void addRows(ComparePart& part, const CompareSubject& subject, CompareMode mode, const GradientComparison& comparison,
             const std::vector<MethodFacts>& facts) {
    const std::string name = compareModeName(mode);
    const double pixels = double(subject.view.width) * subject.view.height;
    for (std::size_t i = 0; i < comparison.results.size(); ++i) {
        const GradientResult& r = comparison.results[i];
        part.resultRows +=
            csvLine({name, r.name, std::to_string(r.statistics.passes()), csvNumber(double(r.paths) / pixels), csvNumber(r.seconds),
                  csvNumber(facts[i].trainSeconds), csvNumber(r.mse), csvNumber(r.relativeVariance.value), csvNumber(r.relativeVariance.error),
                  csvNumber(r.bias.along), csvNumber(r.bias.interval), csvNumber(r.bias.z()), csvNumber(r.efficiency.value),
                  csvNumber(r.efficiency.error), csvNumber(r.ratio.value), csvNumber(r.ratio.error), "", facts[i].chosen});
        for (const CurvePoint& point : r.curve)
            part.curveRows += csvLine({name, r.name, std::to_string(point.passes), csvNumber(point.seconds), csvNumber(point.error)});
        part.table.push_back({{"mode", name},
                              {"method", r.name},
                              {"passes", r.statistics.passes()},
                              {"spp", double(r.paths) / pixels},
                              {"seconds", r.seconds},
                              {"train_seconds", facts[i].trainSeconds},
                              {"mse", r.mse},
                              {"relative_variance", r.relativeVariance.value},
                              {"relative_variance_error", r.relativeVariance.error},
                              {"bias", r.bias.along},
                              {"bias_95", r.bias.interval},
                              {"bias_z", r.bias.z()},
                              {"biased", r.bias.verdict == Bias::Verdict::Biased},
                              {"efficiency", r.efficiency.value},
                              {"efficiency_error", r.efficiency.error},
                              {"ratio", r.ratio.value},
                              {"ratio_error", r.ratio.error},
                              {"chosen", facts[i].chosen}});
    }
}

} // namespace

std::string methodCell(std::size_t index, const CompareMethod& method, const std::string& chosen) {
    return "<span class=\"swatch\" style=\"background:" + curveColor(index) + "\"></span><b>" + escapeHtml(method.name) +
           "</b><span class=\"how\">" + method.describe() + "</span>" +
           (chosen.empty() ? std::string() : "<span class=\"how\"><b>chosen: " + escapeHtml(chosen) + "</b></span>");
}

std::string headlineOf(const GradientComparison& comparison) {
    const auto biased = [](const GradientResult& r) { return r.bias.verdict == Bias::Verdict::Biased; };
    const GradientResult& first = comparison.results.front();
    if (!std::isfinite(first.efficiency.value) || biased(first)) // its error is not known, or does not fall with the time
        return "";
    const GradientResult* best = nullptr;
    bool left = false;
    for (std::size_t i = 1; i < comparison.results.size(); ++i) {
        const GradientResult& r = comparison.results[i];
        left |= biased(r);
        if (!biased(r) && std::isfinite(r.efficiency.value) && (!best || r.efficiency.value > best->efficiency.value))
            best = &r;
    }
    if (!best)
        return "";
    if (!(best->efficiency.value > first.efficiency.value))
        return std::string("No other ") + (left ? "unbiased " : "") + "method is more efficient than <b>" + escapeHtml(first.name) + "</b> here.";
    return "<b>" + escapeHtml(best->name) + "</b> reaches the error of <b>" + escapeHtml(first.name) + "</b> in 1/" +
           withError(best->ratio.value, best->ratio.error) + " of the time.";
}

void warnOfNoDerivative(const MeasuredReference& reference) {
    if (!(reference.reference.squaredNorm() > 0))
        logWarn("the derivative is zero, or the reference is mostly noise: figures relative to it are left out");
}

std::string csvNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return std::isfinite(value) ? text : "";
}

std::string csvLine(const std::vector<std::string>& fields) {
    std::string line;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const bool quoted = fields[i].find(',') != std::string::npos;
        line.append(i == 0 ? "" : ",").append(quoted ? "\"" : "").append(fields[i]).append(quoted ? "\"" : "");
    }
    return line.append("\n");
}

std::vector<std::pair<std::string, Image>> imagesOf(const CompareSubject& subject, CompareMode mode, std::span<const double> values) {
    std::vector<std::pair<std::string, Image>> images;
    if (mode == CompareMode::Forward) {
        Image image(subject.view.width, subject.view.height, 3);
        for (std::size_t i = 0; i < image.values.size(); ++i)
            image.values[i] = float(values[i]);
        images.emplace_back("", std::move(image));
        return images;
    }
    for (std::size_t p = 0; p < subject.session.parameters.size(); ++p) {
        const Parameter& parameter = subject.session.parameter(p);
        images.emplace_back(subject.session.parameters.size() == 1 ? "" : fileName(parameter.name),
                            parameterImage(parameter, values.first(parameter.entries())));
        values = values.subspan(parameter.entries());
    }
    return images;
}

ComparePart gradientPart(const CompareSubject& subject, CompareMode mode, const GradientComparison& comparison,
                         const std::vector<MethodFacts>& facts) {
    const bool forward = mode == CompareMode::Forward;
    ComparePart part;
    ErrorPlot plot;
    plot.title = forward ? "Error of the derivative image" : "Error of the gradient";
    plot.vertical = "mean squared error";
    for (const GradientResult& r : comparison.results) {
        ErrorCurve curve{r.name, {}};
        for (const CurvePoint& point : r.curve)
            curve.points.emplace_back(point.seconds, point.error);
        plot.curves.push_back(std::move(curve));
    }
    if (!comparison.reference.madeBy.empty()) {
        plot.floor = comparison.reference.reference.variance / double(comparison.reference.reference.values.size());
        plot.floorName = "error of the reference itself";
    }
    part.svg = plot.svg();
    addRows(part, subject, mode, comparison, facts);

    const std::string budget = subject.options.time ? shortNumber(double(*subject.options.time)) + " seconds of passes for each method"
                                                    : "the same number of samples for each method";
    part.html = "<section>\n<h2>" + std::string(forward ? "Derivative image" : "Gradient") + " of " + "<code>" + escapeHtml(subject.parameterNames()) + "</code></h2>\n<p class=\"lead\">" +
                (forward ? "How every pixel changes when the parameter does: one image per method, "
                         : "How a function of the image changes with every entry of the parameter: one number per entry, ") +
                budget + ", passes of " + std::to_string(subject.options.effectiveSppGradient()) + " samples per pixel.</p>\n";
    const std::string result = headlineOf(comparison);
    if (!result.empty())
        part.html += "<p class=\"result\">" + result + "</p>\n";
    part.html += subjectFigures(subject, mode) + "<h3>Error over time</h3>\n<div class=\"plot\">" + svgImage(part.svg) + "</div>\n" +
                 htmlTable(gradientTable(subject, comparison, facts)) + estimateFigures(subject, mode, comparison) + explanation(comparison) +
                 "</section>\n";

    const auto addImages = [&](const std::string& name, std::span<const double> values) {
        for (auto& [suffix, image] : imagesOf(subject, mode, values))
            part.images.emplace_back(name + (suffix.empty() ? "" : "." + suffix), std::move(image));
    };
    addImages("reference", comparison.reference.reference.values);
    for (const GradientResult& r : comparison.results)
        addImages(r.name, r.statistics.mean());
    return part;
}

std::string compareDocument(const CompareSubject& subject, const std::string& device, const std::string& configuration,
                            const std::vector<ComparePart>& parts) {
    const std::filesystem::path scene = std::filesystem::absolute(subject.options.input).lexically_normal();
    const std::string name = (scene.parent_path().filename() / scene.filename()).string(); // many scenes are called scene.gltf
    std::string body = "<h1>" + escapeHtml(name) + ": sampling methods compared</h1>\n<p class=\"lead\">" +
                       std::to_string(subject.view.width) + " &times; " + std::to_string(subject.view.height) + " pixels, camera " +
                       escapeHtml(subject.view.camera) + ", on " + escapeHtml(device) + ".</p>\n";
    for (const ComparePart& part : parts)
        body += part.html;
    body += "<details><summary>Options of this run</summary><p><code>" + escapeHtml(configuration) + "</code></p></details>\n";
    return htmlDocument(name + ": comparison", body);
}

} // namespace cmpg
