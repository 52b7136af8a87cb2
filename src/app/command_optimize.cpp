// optimize: recover parameters from target images; the options become a recovery, the results a folder.
#include "app/checkpoints.h"
#include "app/commands.h"
#include "app/display.h"
#include "app/progress.h"
#include "app/run_folder.h"
#include "app/run_pictures.h"
#include "base/log.h"
#include "imaging/parameter_image.h"
#include "session/explain.h"
#include "session/interrupt.h"
#include "session/output.h"
#include "session/ranks.h"
#include "session/session.h"
#include "session/targets.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <unistd.h>
#include <utility>

namespace cmpg {
namespace {

// One view per --target, each of its target's size; the cameras have their names.
struct Views {
    std::vector<SeenView> views;
    std::vector<v1::Target> targets;
    std::vector<std::string> titles; // names of the cameras, where the command line names them
};

void requireInputsApart(const Options& options, const Scene& scene) {
    std::vector<std::filesystem::path> pictures;
    for (const std::vector<std::string>* texts : {&options.target, &options.mask})
        for (const std::string& text : *texts)
            pictures.push_back(cameraFileOf(scene, text).file);
    requireApart(options.output, options.input, pictures);
}

Views loadViews(const Options& options, const Scene& scene) {
    Views result;
    std::size_t bytes = 0;
    requireCamerasNamed(options, scene);
    for (const std::string& text : options.target) {
        const CameraFile given = cameraFileOf(scene, text);
        const auto load = bytes < v1::Target::kMostBytes ? v1::Target::load : v1::Target::stream;
        v1::Target target = averagedTo(options, load(given.file, given.camera, maskOf(options, scene, given.camera), options.targetExposure));
        warnOfTarget(options, scene, given.camera, target);
        bytes += (target.image.values.size() + target.mask.size()) * sizeof(float) + target.clipped.size();
        result.titles.push_back(given.camera);
        result.views.push_back(viewOf(options, scene, given.camera, &target.image));
        target.camera = result.views.back().camera;
        result.targets.push_back(std::move(target));
    }
    requireMasksOf(options, scene, result.titles);
    return result;
}

void writeGradients(const Session& session, const v1::Recovery& run, RunFolder& folder) {
    for (std::size_t p = 0; p < session.parameters.size(); ++p)
        folder.writeGradient(session.parameters[p], parameterImage(session.parameter(p), run.gradient(session.parameters[p])));
}

void addStep(Report& report, const v1::RecoveryStep& step) {
    report.loss.push_back(step.loss);
    report.seconds.primal += step.imageSeconds;
    report.seconds.gradient += step.gradientSeconds;
    report.seconds.optimizer += step.updateSeconds;
    if (step.dropped > 0)
        report.dropped["optimize: non-finite gradient"] += step.dropped;
}

// A hundred times in a run how far it is and what it takes, and each time that what was left out has doubled how much that is.
class RunLog {
  public:
    RunLog(EventLog& log, std::uint32_t steps) : log_(log), interval_(std::max(1u, steps / 100)) {}

    void afterStep(const v1::RecoveryStep& step, const v1::PassReport& passes, const Report& report, const v1::Device& device) {
        for (const v1::Warning& warning : step.warnings)
            log_.warn(warning.event, withOptions(warning.text, warning.options), warning.numbers);
        EventLog::Numbers numbers;
        if ((step.step + 1) % interval_ == 0) {
            numbers = {{"loss", step.loss}, {"gradient_norm", step.gradientNorm}, {"largest_samples", step.concentration}, {"paths", double(passes.paths)},
                       {"device_bytes", double(device.memoryInUse())}, {"host_bytes", double(hostBytes())}};
            if (const Traffic sent = ranks().traffic(); sent.calls > 0)
                numbers.insert(numbers.end(), {{"rank_calls", double(sent.calls)}, {"rank_bytes", double(sent.bytes)}, {"rank_seconds", sent.seconds}});
            log_.info("progress", "", std::exchange(numbers, {}));
        }
        std::uint64_t sum = 0;
        for (const auto* dropped : {&passes.dropped, &report.dropped})
            for (const auto& [kind, count] : *dropped)
                if (count > 0) {
                    numbers.emplace_back(kind, double(count));
                    sum += count;
                }
        if (sum == 0 || sum < 2 * dropped_)
            return;
        dropped_ = sum;
        numbers.emplace_back("paths", double(passes.paths));
        log_.info("dropped", "contributions left out so far, by kernel and kind", std::move(numbers));
    }

  private:
    EventLog& log_;
    std::uint32_t interval_;
    std::uint64_t dropped_ = 0;
};

void showStep(const Session& session, const v1::Recovery& run, DisplayStream& display) {
    for (std::size_t p = 0; display.active() && p < session.parameters.size(); ++p) {
        const Parameter& parameter = session.parameter(p);
        display.show("gradient." + parameter.name, parameterImage(parameter, run.gradient(parameter.name)));
        display.show(parameter.name, parameterImage(parameter, run.values(parameter.name)));
    }
}

// Warns of parameters that went to an end of their range, all of each, while the image is still off by far more than noise: what the target has more or less of
// is then not theirs.
void warnOfEnds(const Session& session, const v1::Recovery& run, const std::vector<std::vector<float>>& start, EventLog& log) {
    constexpr double kErrors = 4;      // standard errors of the loss that is left
    constexpr float kNear = 1e-3f;     // of the range
    constexpr double kMostLoss = 0.05; // of the loss at the start, that a recovery leaves
    const std::vector<v1::RecoveryStep> steps = run.history();
    if (steps.empty() || !(steps.back().loss > kErrors * steps.back().lossError && steps.back().loss > kMostLoss * steps.front().loss))
        return;
    for (std::size_t p = 0; p < session.parameters.size(); ++p) {
        const Parameter& parameter = session.parameter(p);
        const std::vector<float> values = run.values(parameter.name);
        for (const float end : {parameter.lowest(), parameter.highest()}) {
            const auto isThere = [&](float v) { return std::abs(v - end) <= kNear; };
            if (!std::isfinite(end) || !std::all_of(values.begin(), values.end(), isThere) || std::all_of(start[p].begin(), start[p].end(), isThere))
                continue;
            char text[200];
            std::snprintf(text, sizeof text, " ended at %g, the end of its range, and the image is still off: is the target's exposure the scene's (--target-exposure), and its light?",
                          double(end));
            log.warn("at_its_end", parameter.name + text);
        }
    }
}

// Warns of parameters that no step has reached, after as many steps as there are views: each was seen by then, whatever their order.
class UnreachedParameters {
  public:
    UnreachedParameters(const Session& session, std::size_t views) : session_(session), left_(session.parameters), views_(views) {}

    void afterStep(const v1::Recovery& run) {
        if (run.steps() > views_)
            return;
        std::erase_if(left_, [&](const std::string& name) {
            const std::vector<double> gradient = run.gradient(name);
            return std::any_of(gradient.begin(), gradient.end(), [](double g) { return std::isfinite(g) && g != 0; });
        });
        if (run.steps() == views_)
            for (const std::string& name : left_)
                warnUnreached(session_.host(), name, false);
    }

  private:
    const Session& session_;
    std::vector<std::string> left_;
    std::size_t views_;
};

ExitStatus tellErrors(const Options& options, Report& report, const v1::GradientErrors& errors) {
    report.extra["error"] = {{"gradients", errors.gradients}, {"missed", errors.missed}, {"worst", errors.worst}};
    if (errors.missed == 0)
        return ExitStatus::Done;
    char text[200];
    std::snprintf(text, sizeof text, "the error target of %.3g %% was not reached by %llu of %llu gradients: at worst the error is %.3g %%; allow more --spp-gradient",
                  100 * double(*options.errorTarget), static_cast<unsigned long long>(errors.missed),
                  static_cast<unsigned long long>(errors.gradients), 100 * errors.worst);
    logWarn(text);
    return ExitStatus::CheckFailed;
}

} // namespace

ExitStatus runOptimize(const Options& options, Report& report) {
    Options effective = options;
    Session session(options, report);
    effective.maxDepth = options.effectiveDepth(session.host().maxDepth);
    v1::RecoveryOptions how = recoveryOptions(options, *effective.maxDepth);
    how.parameters = session.parameters;
    requireInputsApart(options, session.host());
    Views views = loadViews(options, session.host());
    requireWritableFolder(options.output);
    requireWritableGuide(options.saveGuide);
    const std::filesystem::path output = ranks().isRoot() ? options.output : std::string(); // one rank writes
    EventLog log(output.empty() ? output : output / "log.jsonl");
    v1::Recovery run(session.openDevice(), session.scene, views.targets, how);
    views.targets = {}; // the run has its own
    session.begin(views.views.front(), output);
    stopOnInterrupt();

    DisplayStream display(options.displayServer, displayTitle(options));
    run.onImage([&](std::size_t view, const Image& image) { display.show(views.views.size() == 1 ? "image" : "image." + std::to_string(view), image); });
    Checkpoints checkpoints(effective, log);
    checkpoints.resume(run);
    const std::vector<v1::RecoveryStep> before = run.history();
    RunFolder folder(output, before);
    for (const v1::RecoveryStep& step : before)
        addStep(report, step);
    run.prepare();
    log.info(before.empty() ? "started" : "resumed", options.input, {{"steps", double(how.steps)}, {"seconds", report.elapsed()}});
    std::vector<std::string> failures; // to write
    folder.tolerate([&](const Error& error) {
        failures.push_back(error.what());
        log.warn("write_failed", std::string(error.what()) + (error.cause.empty() ? "" : ": " + error.cause) + ". The run continues in memory");
    });

    RunLog runLog(log, how.steps);
    UnreachedParameters unreached(session, views.views.size());
    std::uint32_t end = std::min(how.steps, options.stopAfter.value_or(how.steps));
    Progress progress(std::cerr, isatty(STDERR_FILENO) != 0, end);
    double lastStep = report.elapsed();
    double pathSeconds = 0; // of the step whose paths took least, which compiled least; 0: not known
    if (how.warmUp >= how.steps)
        log.warn("nothing_recovered", "all " + std::to_string(how.steps) + " steps are of --warm-up: they learn the guide, and leave the parameters as they are");
    bool stopped = false;
    std::optional<Error> failure;
    try {
        while (!stopped && run.steps() < end) {
            const v1::RecoveryStep step = run.step();
            const double now = report.elapsed(), beside = now - std::exchange(lastStep, now) - step.seconds;
            const StepAgreement agreed = agreeAfterStep(options.timeBudget && now + beside + step.nextSeconds > double(*options.timeBudget), stopRequested());
            if (agreed.timeUp)
                end = step.step + 1;
            stopped = agreed.stop;
            log.setStep(step.step + 1);
            addStep(report, step);
            if (const double each = (step.imageSeconds + step.gradientSeconds) / double(step.paths); each > 0)
                pathSeconds = pathSeconds > 0 ? std::min(pathSeconds, each) : each;
            folder.appendStep(step);
            checkpoints.afterStep(run);
            runLog.afterStep(step, run.report(), report, session.openDevice());
            showStep(session, run, display);
            if (before.empty()) // what earlier steps of a run that continues have reached is not known
                unreached.afterStep(run);
            if (!options.quiet)
                progress.update(step, options.timeBudget ? std::optional(*options.timeBudget - now) : std::nullopt);
        }
    } catch (const Error& e) {
        failure = e; // the state is that after a whole step: worth keeping
    }
    if (!options.quiet)
        progress.finish();

    log.setStep(run.steps());
    checkpoints.write(run);
    folder.attempt([&] {
        session.record([&](Options& o) {
            if (std::exchange(o.timeBudget, {}))
                o.stopAfter = run.steps();
        });
    });
    std::vector<std::vector<float>> start;
    for (const std::string& name : session.parameters)
        start.push_back(session.scene.values(name));
    warnOfEnds(session, run, start, log);
    folder.writeLosses(run.history());
    folder.attempt([&] {
        run.apply(session.scene);
        folder.writeScene(session.scene);
    });
    if (failure && failure->kind != ErrorKind::Numerical) { // no device, no pictures
        failure->remedy += (failure->remedy.empty() ? "" : ". ") + ("--resume " + folder.path().string() + " continues from here");
        log.warn("failed", failure->what());
        throw *failure;
    }
    std::uint32_t pictureSpp = pictureSamples(options, views.views, pathSeconds);
    if (options.timeBudget) {
        pictureSpp = ofFirstRank(pictureSpp); // each has measured its own steps
        folder.attempt([&] { session.record([&](Options& o) { o.sppPictures = pictureSpp; }); });
    }
    std::vector<ContactSheet::ViewRow> pictures = writePictures(run, pictureSpp, views.titles, folder);
    writeGradients(session, run, folder);
    for (const auto& [name, path] : folder.outputs())
        report.outputs.emplace_back(name, path.string());
    folder.attempt([&] { writeContactSheet(options, session, run, start, std::move(pictures), folder, report); });
    const v1::PassReport passes = run.report();
    session.add(passes);
    folder.attempt([&] { session.tell(passes, run); });
    session.finish();
    log.info(!stopped && !failure ? "finished" : "interrupted", "results written", {{"failed_writes", double(failures.size())}});
    if (failure)
        throw *failure;
    if (!failures.empty())
        throw Error(ErrorKind::Output, "not everything could be written: " + failures.back(), "the disk is full, or the folder read-only or gone",
                    "make space and run again with --resume " + folder.path().string());
    if (!options.quiet)
        textOut(options) << "wrote " << (folder.path() / "contact_sheet.png").string() << '\n';
    if (stopped)
        return ExitStatus::Interrupted;
    return options.errorTarget ? tellErrors(options, report, run.errors()) : ExitStatus::Done;
}

} // namespace cmpg
