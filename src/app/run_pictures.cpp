// What a run of optimize shows.
#include "app/run_pictures.h"

#include "imaging/loss_curve.h"
#include "imaging/parameter_image.h"
#include "session/output.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

// With its standard error where that says more than the value: an image of a few bright dots tells nothing of how far it is off.
std::string lossText(const v1::RecoveryStep& step) {
    char text[64];
    if (step.lossError > std::abs(step.loss))
        std::snprintf(text, sizeof text, "%.3g \xc2\xb1 %.2g", step.loss, step.lossError);
    else
        std::snprintf(text, sizeof text, "%.3g", step.loss);
    return text;
}

} // namespace

std::uint32_t pictureSamples(const Options& options, std::span<const SeenView> views, double pathSeconds) {
    constexpr std::uint32_t kFactor = 4, kLeast = 64, kFew = 4, kLeastOfMany = 8, kLeastInTime = 16, kLeastOfLarge = 2;
    constexpr double kShareOfTime = 0.1, kSmall = 128 * 128; // pixels
    if (options.sppPictures)
        return *options.sppPictures;
    std::uint32_t samples = std::max(kLeast, options.effectiveSpp() * kFactor);
    if (views.size() > kFew)
        samples = std::max(kLeastOfMany, std::uint32_t(std::uint64_t(samples) * kFew / views.size()));
    if (!options.timeBudget || !(pathSeconds > 0))
        return samples;
    double pixels = 0, largest = 0; // of both pictures of all views; of a view
    for (const SeenView& view : views) {
        const double own = double(view.width) * view.height;
        pixels += 2 * own;
        largest = std::max(largest, own);
    }
    const double fits = kShareOfTime * double(*options.timeBudget) / (pixels * pathSeconds);
    const double least = std::clamp(kLeastInTime * kSmall / largest, double(kLeastOfLarge), double(kLeastInTime));
    return std::uint32_t(std::clamp(fits, std::min(least, double(samples)), double(samples)));
}

std::vector<ContactSheet::ViewRow> writePictures(v1::Recovery& run, std::uint32_t spp, const std::vector<std::string>& titles, RunFolder& folder) {
    const std::size_t views = titles.size();
    std::vector<ContactSheet::ViewRow> rows;
    for (std::size_t view = 0; view < views; ++view) {
        Image target = run.target(view), initial = run.image(view, spp, true), recovered = run.image(view, spp), difference = run.difference(recovered, view);
        folder.writeView("target", view, views, target);
        folder.writeView("initial", view, views, initial);
        folder.writeView("final", view, views, recovered);
        folder.writeView("difference", view, views, difference);
        if (view < ContactSheet::kMostRows)
            rows.push_back({titles[view], std::move(target), std::move(initial), std::move(recovered), std::move(difference)});
    }
    return rows;
}

void writeContactSheet(const Options& options, const Session& session, const v1::Recovery& run, const std::vector<std::vector<float>>& start,
                       std::vector<ContactSheet::ViewRow> views, const RunFolder& folder, Report& report) {
    ContactSheet sheet;
    sheet.views = std::move(views);
    const std::filesystem::path scene = std::filesystem::absolute(options.input);
    sheet.title = (scene.parent_path().filename() / scene.filename()).string(); // many scenes are called scene.gltf
    if (const std::vector<v1::RecoveryStep> steps = run.history(); !steps.empty())
        sheet.title += ", " + std::to_string(steps.size()) + " steps, " + nameOf(options.loss, kLosses) + " " + lossText(steps.front()) + " to " + lossText(steps.back());
    if (const std::size_t all = options.target.size(); all > sheet.views.size())
        sheet.title += ", the first " + std::to_string(sheet.views.size()) + " of " + std::to_string(all) + " views";
    for (std::size_t p = 0; p < session.parameters.size(); ++p) {
        const Parameter& parameter = session.parameter(p);
        sheet.parameters.push_back({parameter.name, parameter.kind, parameterImage(parameter, start[p]), parameterImage(parameter, run.values(parameter.name)),
                                    parameterImage(parameter, run.gradient(parameter.name))});
    }
    sheet.loss = report.loss;
    for (const v1::RecoveryStep& step : run.history())
        sheet.lossError.push_back(step.lossError);
    const std::filesystem::path picture = folder.path() / "contact_sheet.png", curve = folder.path() / "loss.svg";
    writePng(picture, sheet.compose());
    writeTextFile(curve, lossCurveSvg(report.loss, sheet.title, sheet.lossError));
    report.outputs.emplace_back("contact_sheet", picture.string());
    report.outputs.emplace_back("loss_curve", curve.string());
}

} // namespace cmpg
