// gradient: derivatives of the image (forward), of a function of it (reverse), and their check against finite differences.
#include "app/check_table.h"
#include "app/commands.h"
#include "app/display.h"
#include "base/communicator.h"
#include "imaging/parameter_image.h"
#include "scene/export_folder.h"
#include "session/output.h"
#include "session/parameter_values.h"
#include "session/render_session.h"
#include "session/targets.h"

#include <algorithm>

namespace cmpg {
namespace {

std::vector<v1::Direction> directionsOf(const RenderSession& session, const std::string& direction) {
    std::vector<v1::Direction> directions;
    for (std::size_t p = 0; p < session.parameters.size(); ++p)
        directions.push_back({session.parameters[p], directionOf(session.parameter(p), direction)});
    return directions;
}

Image forward(const Options& options, Report& report, RenderSession& session, const std::vector<v1::Direction>& directions, v1::PassReport& done) {
    DisplayStream display(options.displayServer, displayTitle(options));
    v1::PassOptions pass = session.pass(options.effectiveSppGradient());
    pass.onImage = shownIn(display, "gradient");
    Image gradient = session.renderer().forward(directions, pass, &done);
    session.add(done);
    report.seconds.gradient += done.seconds;
    return gradient;
}

Image adjointOfLoss(const Options& options, Report& report, RenderSession& session, const v1::Target& target, DisplayStream& display) {
    v1::PassOptions pass = session.plainPass(options.effectiveSpp());
    pass.frozen = true;
    v1::PassReport done;
    const Image image = session.renderer().render(pass, &done);
    session.add(done);
    report.seconds.primal = done.seconds;
    display.show("image", image);
    v1::ImageLoss loss = v1::lossOf(options.loss, image, target);
    if (loss.nonFinite > 0)
        report.dropped["loss.nonfinite"] += loss.nonFinite;
    report.loss.push_back(loss.value);
    return std::move(loss.adjoint);
}

void writeGradients(const Options& options, Report& report, RenderSession& session, const std::vector<std::vector<double>>& gradients) {
    for (std::size_t i = 0; i < session.parameters.size(); ++i) {
        const Parameter& parameter = session.parameter(i);
        const bool single = session.parameters.size() == 1;
        const std::filesystem::path file = single ? std::filesystem::path(options.output)
                                                  : std::filesystem::path(options.output) / (fileName(parameter.name) + ".exr");
        if (ranks().isRoot())
            writeExr(file, parameterImage(parameter, gradients[i]));
        warnUnreached(session.host(), parameter.name, std::any_of(gradients[i].begin(), gradients[i].end(), [](double g) { return g != 0; }));
        report.outputs.emplace_back(single ? "gradient" : parameter.name, file.string());
    }
}

ExitStatus runReverse(const Options& options, Report& report, RenderSession& session) {
    const bool single = session.parameters.size() == 1;
    if (single)
        requireWritableFile(options.output, ".exr");
    else
        requireWritableFolder(options.output);
    requireWritableGuide(options.saveGuide);

    DisplayStream display(options.displayServer, displayTitle(options));
    Image adjoint;
    v1::Target target;
    if (options.target.empty())
        adjoint = readColorImage(options.adjoint);
    else
        target = averagedTo(options, openTarget(options, session.scene, options.target.front()));
    const SeenView view = viewOf(options, session.host(), target.camera, options.target.empty() ? &adjoint : &target.image);
    const std::filesystem::path folder = single ? folderOf(options.output) : std::filesystem::path(options.output);
    if (options.target.empty()) {
        session.prepare(view, folder, {v1::PassKind::Backward});
    } else {
        session.prepare(view, folder, {v1::PassKind::Render, v1::PassKind::Backward});
        adjoint = adjointOfLoss(options, report, session, target, display);
    }

    const std::uint32_t images = report.spp;
    v1::PassReport done;
    const std::vector<std::vector<double>> gradients =
        session.renderer().backward(adjoint, session.pass(options.effectiveSppGradient()), &done);
    session.add(done);
    report.seconds.gradient = done.seconds;
    const ExitStatus code = session.conclude(done, &Options::sppGradient);
    if (!options.target.empty() && done.batches == 0)
        report.spp = images;

    for (std::size_t i = 0; i < gradients.size(); ++i)
        display.show("gradient." + session.parameters[i], parameterImage(session.parameter(i), gradients[i]));
    writeGradients(options, report, session, gradients);
    session.tell(done);
    session.finish();
    return code;
}

nlohmann::ordered_json toJson(const Comparison& c) {
    return {{"what", c.what},     {"forward", c.forward},
            {"finite", c.finite}, {"standard_error", c.standardError},
            {"z", c.z()},         {"relative_error", c.relativeError()},
            {"power", c.power()}, {"probability", c.probability}};
}

bool checkParameter(const Options& options, Report& report, RenderSession& session, const v1::Direction& direction) {
    v1::PassReport done;
    const CheckResult result = session.renderer().check(direction, session.plainPass(options.effectiveSpp()), options.effectiveSppGradient(), &done);
    session.add(done);
    report.seconds.gradient += done.seconds;
    report.seconds.primal += done.imageSeconds;
    textOut(options) << checkTable(result, direction.parameter, options.direction) << std::flush;
    auto comparisons = nlohmann::ordered_json::array();
    for (const Comparison& c : result.comparisons)
        comparisons.push_back(toJson(c));
    report.extra["check"].push_back({{"parameter", direction.parameter},
                                     {"step", result.step},
                                     {"agrees", result.agrees()},
                                     {"threshold", result.threshold},
                                     {"comparisons", comparisons}});
    return result.agrees();
}

ExitStatus runForward(const Options& options, Report& report, RenderSession& session) {
    if (!options.output.empty())
        requireWritableFile(options.output, ".exr");
    if (!options.layers.empty())
        requireWritableFile(options.layers, ".exr");
    requireWritableGuide(options.saveGuide);
    const std::vector<v1::Direction> directions = directionsOf(session, options.direction); // reports a bad file before anything else
    constexpr int kCheckWidth = 128;                                                        // many renders, compared by blocks
    const SeenView view = viewOf(options, session.host(), "", nullptr, options.check ? kCheckWidth : 512);
    const std::filesystem::path folder = options.output.empty() ? std::filesystem::path() : folderOf(options.output);
    if (options.check)
        session.prepare(view, folder, {v1::PassKind::Render, v1::PassKind::Forward});
    else
        session.prepare(view, folder, {v1::PassKind::Forward});
    bool agrees = true;
    ExitStatus code = ExitStatus::Done;
    if (options.check) {
        report.extra["check"] = nlohmann::ordered_json::array();
        for (const v1::Direction& direction : directions)
            agrees = checkParameter(options, report, session, direction) && agrees;
    }
    if (options.output.empty()) {
        session.finish();
    } else {
        v1::PassReport done;
        const Image gradient = forward(options, report, session, directions, done);
        code = session.conclude(done, &Options::sppGradient);
        if (session.parameters.size() == 1)
            warnUnreached(session.host(), session.parameters[0], std::any_of(gradient.values.begin(), gradient.values.end(), [](float g) { return g != 0; }));
        if (ranks().isRoot())
            writeExr(options.output, gradient);
        report.outputs.emplace_back("gradient", options.output);
        session.tell(done);
        session.finish(&gradient);
    }
    return agrees ? code : ExitStatus::CheckFailed;
}

} // namespace

ExitStatus runGradient(const Options& options, Report& report) {
    RenderSession session(options, report);
    return options.isReverse() ? runReverse(options, report, session) : runForward(options, report, session);
}

} // namespace cmpg
