// gradient: derivatives of the image (forward), of a function of it (reverse), and their check against finite differences.
#include "app/commands.h"
#include "app/display.h"
#include "base/communicator.h"
#include "imaging/layers_file.h"
#include "lab/batched_passes.h"
#include "lab/gradient_check.h"
#include "optimize/run_folder.h"
#include "session/guided_session.h"
#include "session/output.h"
#include "session/parameter_values.h"
#include "session/session.h"
#include "session/targets.h"

#include <algorithm>

namespace cmpg {
namespace {

// Random numbers of the derivative pass; those of the primal pass are independent.
PassKey derivativeKey(const Options& o) {
    return {.seed = o.seed, .pass = 1};
}

std::vector<std::vector<float>> directionsOf(const Session& session, const std::string& direction) {
    std::vector<std::vector<float>> directions;
    for (std::uint32_t p : session.parameters)
        directions.push_back(directionOf(session.scene.parameters[p], direction));
    return directions;
}

Image forward(const Options& options, Report& report, Session& session, const View& view, ExitStatus& code) {
    const std::vector<std::vector<float>> directions = directionsOf(session, options.direction);
    const std::uint32_t spp = options.effectiveSppGradient();
    GuidedSession guided(options, report, session);
    guided.train([&](std::uint32_t passes) { guided.passes().trainForward(view, options.effectiveTrainSpp(), passes, options.seed, session.parameters, directions); });
    const bool layered = !options.layers.empty();
    guided.passes().prepareNext(Renderer::Mode::Forward, layered);
    const Stopwatch watch;
    DisplayStream display(options.displayServer, displayTitle(options));
    Layers layers;
    Image gradient;
    if (const std::uint32_t batches = options.effectiveBatches()) {
        const BudgetedEstimate estimate = spendBudget(
            sampleBudget(options, report, spp),
            [&](const BatchPart& part) {
                return fromImage(guided.passes().forward(view, part.samples, partKey(derivativeKey(options), part, batches, !options.positivize),
                                                         session.parameters, directions));
            },
            [&](const BudgetedEstimate& e) {
                if (display.active())
                    display.show("gradient", toImage(e.mean, view.width, view.height));
            });
        gradient = toImage(estimate.mean, view.width, view.height);
        report.seconds.gradient += watch.seconds();
        code = conclude(estimate, options, report, session, &Options::sppGradient);
        guided.finish();
        return gradient;
    }
    if (display.active() && !options.positivize) {
        Film film(view.width, view.height, layered);
        showGrowing(display, "gradient", film, spp,
                    [&](std::uint32_t part) { guided.passes().forward(view, part, derivativeKey(options), session.parameters, directions, film); });
        gradient = film.image();
        layers = film.layers();
    } else {
        gradient = guided.passes().forward(view, spp, derivativeKey(options), session.parameters, directions, layered ? &layers : nullptr);
        display.show("gradient", gradient);
    }
    report.seconds.gradient += watch.seconds();
    report.spp = spp;
    if (layered && ranks().isRoot()) {
        writeLayers(options.layers, layers, usesGuide(options));
        report.outputs.emplace_back("layers", options.layers);
    }
    guided.finish();
    return gradient;
}

Image adjointOfLoss(const Options& options, Report& report, Session& session, const View& view, const Target& target, DisplayStream& display) {
    const Stopwatch watch;
    const Image image = session.renderer().render(view, options.effectiveSpp(), {.seed = options.seed});
    report.seconds.primal = watch.seconds();
    display.show("image", image);
    LossResult loss = evaluateLoss(options.loss, image, target.image, target.mask);
    if (loss.nonFinite > 0)
        report.dropped["loss.nonfinite"] += loss.nonFinite;
    report.loss.push_back(loss.value);
    return std::move(loss.adjoint);
}

void writeGradients(const Options& options, Report& report, Session& session, const std::vector<std::vector<double>>& gradients) {
    for (std::size_t i = 0; i < session.parameters.size(); ++i) {
        const Parameter& parameter = session.scene.parameters[session.parameters[i]];
        const bool single = session.parameters.size() == 1;
        const std::filesystem::path file = single ? std::filesystem::path(options.output)
                                                  : std::filesystem::path(options.output) / (parameterFileName(parameter.name) + ".exr");
        if (ranks().isRoot())
            writeExr(file, parameterImage(parameter, gradients[i]));
        session.warnUnreached(session.parameters[i], std::any_of(gradients[i].begin(), gradients[i].end(), [](double g) { return g != 0; }));
        report.outputs.emplace_back(single ? "gradient" : parameter.name, file.string());
    }
}

ExitStatus runReverse(const Options& options, Report& report, Session& session) {
    const bool single = session.parameters.size() == 1;
    if (single)
        requireWritableFile(options.output, ".exr");
    else
        requireWritableFolder(options.output);

    DisplayStream display(options.displayServer, displayTitle(options));
    Image adjoint;
    Target target;
    std::string camera;
    if (options.target.empty()) {
        adjoint = readColorImage(options.adjoint);
    } else {
        const CameraTarget chosen = loadCameraTarget(options, session.scene, options.target.front());
        camera = chosen.camera;
        target = chosen.target;
    }
    const View view = viewOf(options, session.scene, camera, options.target.empty() ? &adjoint : &target.image);
    const std::filesystem::path folder = single ? folderOf(options.output) : std::filesystem::path(options.output);
    if (options.target.empty()) {
        session.prepare(view, folder, {Renderer::Mode::Reverse});
    } else {
        session.prepare(view, folder, {Renderer::Mode::Render, Renderer::Mode::Reverse});
        adjoint = adjointOfLoss(options, report, session, view, target, display);
    }

    const std::uint32_t spp = options.effectiveSppGradient();
    if (options.target.empty())
        report.spp = spp;
    GuidedSession guided(options, report, session);
    guided.train([&](std::uint32_t passes) { guided.passes().trainReverse(view, options.effectiveTrainSpp(), passes, options.seed, adjoint); });
    guided.passes().prepareNext(Renderer::Mode::Reverse);
    const Stopwatch watch;
    std::vector<std::vector<double>> gradients;
    for (std::uint32_t p : session.parameters)
        gradients.emplace_back(session.scene.parameters[p].entries());
    ExitStatus code = ExitStatus::Done;
    if (const std::uint32_t batches = options.effectiveBatches()) {
        const bool continues = !options.positivize && options.pixelSampling == PixelSampling::Uniform;
        const BudgetedEstimate estimate = spendBudget(sampleBudget(options, report, spp), [&](const BatchPart& part) {
            std::vector<std::vector<double>> found;
            guided.passes().reverse(view, part.samples, partKey(derivativeKey(options), part, batches, continues), adjoint, found);
            return joined(found);
        });
        divide(estimate.mean, gradients);
        code = conclude(estimate, options, report, session, &Options::sppGradient);
    } else {
        guided.passes().reverse(view, spp, derivativeKey(options), adjoint, gradients);
    }
    report.seconds.gradient = watch.seconds();

    for (std::size_t i = 0; i < gradients.size(); ++i) {
        const Parameter& parameter = session.scene.parameters[session.parameters[i]];
        display.show("gradient." + parameter.name, parameterImage(parameter, gradients[i]));
    }
    guided.finish();
    writeGradients(options, report, session, gradients);
    session.finish();
    return code;
}

nlohmann::ordered_json toJson(const Comparison& c) {
    return {{"what", c.what},     {"forward", c.forward},
            {"finite", c.finite}, {"standard_error", c.standardError},
            {"z", c.z()},         {"relative_error", c.relativeError()},
            {"power", c.power()}, {"probability", c.probability}};
}

bool checkParameter(const Options& options, Report& report, Session& session, const View& view, std::uint32_t index) {
    const Parameter& parameter = session.scene.parameters[index];
    CheckSubject subject;
    subject.parameter = &parameter;
    subject.values = valuesOf(parameter);
    subject.direction = directionOf(parameter, options.direction);
    const std::vector<std::vector<float>> direction{subject.direction};
    const std::uint32_t parameters[] = {index};
    subject.forward = [&](std::uint32_t repetition) {
        const Stopwatch watch;
        Image image = session.renderer().forward(view, options.effectiveSppGradient(),
                                                 {.seed = options.seed, .step = repetition, .pass = 1}, parameters, direction);
        report.seconds.gradient += watch.seconds();
        return image;
    };
    subject.render = [&](std::uint32_t repetition, std::span<const float> values) {
        const Stopwatch watch;
        session.renderer().setParameter(index, values);
        Image image = session.renderer().render(view, options.effectiveSpp(), {.seed = options.seed, .step = repetition});
        session.renderer().setParameter(index, subject.values);
        report.seconds.primal += watch.seconds();
        return image;
    };
    const CheckResult result = checkGradient(subject);
    textOut(options) << describe(result, parameter.name, options.direction) << std::flush;
    auto comparisons = nlohmann::ordered_json::array();
    for (const Comparison& c : result.comparisons)
        comparisons.push_back(toJson(c));
    report.extra["check"].push_back({{"parameter", parameter.name},
                                     {"step", result.step},
                                     {"agrees", result.agrees()},
                                     {"threshold", result.threshold},
                                     {"comparisons", comparisons}});
    return result.agrees();
}

ExitStatus runForward(const Options& options, Report& report, Session& session) {
    if (!options.output.empty())
        requireWritableFile(options.output, ".exr");
    if (!options.layers.empty())
        requireWritableFile(options.layers, ".exr");
    directionsOf(session, options.direction); // reports a bad file before anything else
    constexpr int kCheckWidth = 128;          // many renders, compared by blocks
    const View view = viewOf(options, session.scene, "", nullptr, options.check ? kCheckWidth : 512);
    const std::filesystem::path folder = options.output.empty() ? std::filesystem::path() : folderOf(options.output);
    if (options.check)
        session.prepare(view, folder, {Renderer::Mode::Render, Renderer::Mode::Forward});
    else
        session.prepare(view, folder, {Renderer::Mode::Forward}, !options.layers.empty());
    bool agrees = true;
    ExitStatus code = ExitStatus::Done;
    if (options.check) {
        report.extra["check"] = nlohmann::ordered_json::array();
        for (std::uint32_t p : session.parameters)
            agrees = checkParameter(options, report, session, view, p) && agrees;
    }
    if (options.output.empty()) {
        session.finish();
    } else {
        const Image gradient = forward(options, report, session, view, code);
        if (session.parameters.size() == 1)
            session.warnUnreached(session.parameters[0], std::any_of(gradient.values.begin(), gradient.values.end(), [](float g) { return g != 0; }));
        if (ranks().isRoot())
            writeExr(options.output, gradient);
        report.outputs.emplace_back("gradient", options.output);
        session.finish(&gradient);
    }
    return agrees ? code : ExitStatus::CheckFailed;
}

} // namespace

ExitStatus runGradient(const Options& options, Report& report) {
    Session session(options, report);
    return options.isReverse() ? runReverse(options, report, session) : runForward(options, report, session);
}

} // namespace cmpg
