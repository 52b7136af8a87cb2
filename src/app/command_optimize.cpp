// optimize: recover parameters from target images; the options become a configuration, the results a folder.
#include "app/checkpoints.h"
#include "app/commands.h"
#include "app/display.h"
#include "app/run_identity.h"
#include "base/communicator.h"
#include "base/log.h"
#include "imaging/contact_sheet.h"
#include "imaging/loss_curve.h"
#include "optimize/batched_model.h"
#include "optimize/gradient_watch.h"
#include "optimize/optimize.h"
#include "optimize/progress.h"
#include "optimize/recovery_run.h"
#include "optimize/run_folder.h"
#include "session/explain.h"
#include "session/guided_session.h"
#include "session/interrupt.h"
#include "session/optimize_options.h"
#include "session/output.h"
#include "session/ranks.h"
#include "session/session.h"
#include "session/targets.h"

#include <algorithm>
#include <atomic>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>
#include <unistd.h>

namespace cmpg {
namespace {

struct Views {
    std::vector<View> views;
    std::vector<std::string> names; // of the cameras, where the command line names them
};

// One view per --target, each of its target's size.
Views loadViews(const Options& options, const Scene& scene, OptimizeConfig& config) {
    Views result;
    for (const std::string& text : options.target) {
        CameraTarget target = loadCameraTarget(options, scene, text);
        result.views.push_back(viewOf(options, scene, target.camera, &target.target.image));
        result.names.push_back(target.camera);
        config.targets.push_back(std::move(target.target));
    }
    return result;
}

// Of each parameter, in the run's order.
using Values = std::vector<std::vector<float>>;

Values valuesOf(const Optimization& run) {
    Values values;
    for (const std::uint32_t p : run.parameters())
        values.push_back(run.scene().parameters[p].values);
    return values;
}

Image valuesImage(const Parameter& parameter, const std::vector<float>& values) {
    Image image(int(parameter.width), int(parameter.height), int(parameter.channels));
    image.values = values;
    return image;
}

void writeContactSheet(const Options& options, const Optimization& run, const Values& start, const RunFolder& folder, const Views& views, Report& report) {
    ContactSheet sheet;
    char numbers[96] = "";
    if (!report.loss.empty())
        std::snprintf(numbers, sizeof numbers, ", %zu steps, %s %.3g to %.3g", report.loss.size(), lossName(options.loss),
                      report.loss.front(), report.loss.back());
    const std::filesystem::path scene = std::filesystem::absolute(options.input);
    sheet.title = (scene.parent_path().filename() / scene.filename()).string() + numbers; // many scenes are called scene.gltf
    for (std::size_t v = 0; v < views.views.size(); ++v)
        sheet.views.push_back({views.names[v], run.config().targets[v].image, folder.initialImages().at(v), folder.finalImages().at(v)});
    for (std::size_t p = 0; p < run.gradients().size(); ++p) {
        const Parameter& parameter = run.scene().parameters[run.parameters()[p]];
        sheet.parameters.push_back({parameter.name, parameter.kind, valuesImage(parameter, start[p]), valuesImage(parameter, parameter.values),
                                    parameterImage(parameter, run.gradients()[p])});
    }
    sheet.loss = report.loss;
    for (const StepRecord& step : run.state().history)
        sheet.lossError.push_back(step.lossError);
    const std::filesystem::path picture = folder.path() / "contact_sheet.png", curve = folder.path() / "loss.svg";
    writePng(picture, sheet.compose());
    writeTextFile(curve, lossCurveSvg(report.loss, sheet.title, sheet.lossError));
    report.outputs.emplace_back("contact_sheet", picture.string());
    report.outputs.emplace_back("loss_curve", curve.string());
}

void addStep(Report& report, const StepRecord& step) {
    report.loss.push_back(step.loss);
    report.seconds.primal += step.secondsPrimal;
    report.seconds.gradient += step.secondsGradient;
    report.seconds.optimizer += step.secondsUpdate;
    if (step.dropped > 0)
        report.dropped["optimize: non-finite gradient"] += step.dropped;
}

// A hundred times in a run how far it is and what it takes, and each time that what was left out has doubled how much that is.
class RunLog {
  public:
    RunLog(EventLog& log, std::uint32_t steps) : log_(log), interval_(std::max(1u, steps / 100)) {}

    void afterStep(const StepReport& step, const RenderStatistics& statistics, const Report& report, const MemoryUse& device) {
        for (const GradientWatch::Finding& finding : watch_.observe(step))
            log_.warn(finding.event, withOptions(finding.text, finding.options), finding.numbers);
        EventLog::Numbers numbers;
        if ((step.step + 1) % interval_ == 0) {
            numbers = {{"loss", step.loss}, {"gradient_norm", recordOf(step).gradientNorm}, {"largest_samples", step.concentration}, {"paths", double(statistics.paths)},
                       {"device_bytes", double(device.current)}, {"host_bytes", double(hostBytes())}};
            if (const Traffic sent = ranks().traffic(); sent.calls > 0)
                numbers.insert(numbers.end(), {{"rank_calls", double(sent.calls)}, {"rank_bytes", double(sent.bytes)}, {"rank_seconds", sent.seconds}});
            log_.info("progress", "", std::exchange(numbers, {}));
        }
        std::uint64_t sum = 0;
        for (const auto* dropped : {&statistics.dropped, &report.dropped})
            for (const auto& [kind, count] : *dropped)
                if (count > 0) {
                    numbers.emplace_back(kind, double(count));
                    sum += count;
                }
        if (sum == 0 || sum < 2 * dropped_)
            return;
        dropped_ = sum;
        numbers.emplace_back("paths", double(statistics.paths));
        log_.info("dropped", "contributions left out so far, by kernel and kind", std::move(numbers));
    }

  private:
    EventLog& log_;
    std::uint32_t interval_;
    GradientWatch watch_;
    std::uint64_t dropped_ = 0;
};

void showStep(const Optimization& run, DisplayStream& display) {
    for (std::size_t i = 0; display.active() && i < run.parameters().size(); ++i) {
        const Parameter& parameter = run.scene().parameters[run.parameters()[i]];
        display.show("gradient." + parameter.name, parameterImage(parameter, run.gradients()[i]));
        display.show(parameter.name, valuesImage(parameter, parameter.values));
    }
}

// Images at the start and at the end, both by what has been learned: so they differ by what the parameters changed, not by how they
// were sampled. They come last, so that no time of a budget is theirs.
void writePictures(Optimization& run, ImageModel& model, RunFolder& folder, const Values& start, std::uint32_t spp) {
    const Values end = valuesOf(run);
    const auto set = [&](const Values& values) {
        for (std::size_t i = 0; i < values.size(); ++i)
            model.setParameter(run.parameters()[i], values[i]);
    };
    set(start);
    folder.writeInitial(run, spp);
    set(end);
    folder.writeImages(run, spp);
}

// The gradients of one step go on until their error is small enough; what they take is not known in advance, so time ends whole steps.
std::unique_ptr<BatchedModel> batchedModel(const Options& options, ImageModel& inner) {
    if (!options.errorTarget)
        return nullptr;
    const std::uint32_t batches = options.effectiveBatches();
    return std::make_unique<BatchedModel>(
        inner, SampleBudget{.batches = batches, .samples = options.effectiveSppGradient() / batches, .error = double(*options.errorTarget)});
}

ExitStatus tellErrors(const Options& options, Report& report, const BatchedModel& model) {
    const BatchedModel::Tally& errors = model.tally();
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
    OptimizeConfig config = optimizeConfig(options);
    Session session(options, report);
    const Views views = loadViews(options, session.scene, config);
    requireWritableFolder(options.output);
    const std::filesystem::path output = ranks().isRoot() ? options.output : std::string(); // one rank writes
    EventLog log(output.empty() ? output : output / "log.jsonl");
    Options effective = options;
    effective.maxDepth = options.effectiveDepth(session.scene.maxDepth);
    Checkpoint::Identity identity = runIdentity(effective, session.scene, session.parameters, views.views, config.targets);
    std::optional<RecoveryRun> recovery;
    session.prepare(views.views.front(), output, [&](const RenderConfig& rendering) -> Renderer& {
        return recovery.emplace(session.device(), session.scene, rendering, sessionOptions(options)).renderer();
    });
    GuidedSession guided(options, report, session, recovery->passes());
    stopOnInterrupt();
    std::atomic<bool> stop = false; // agreed on
    config.stop = &stop;

    DisplayStream display(options.displayServer, displayTitle(options));
    config.onImage = [&](std::size_t view, const Image& image) {
        display.show(views.views.size() == 1 ? "image" : "image." + std::to_string(view), image);
    };
    const BatchedModel* batched = nullptr; // where gradients have an error target
    recovery->begin({.config = std::move(config),
                     .views = views.views,
                     .learn = usesGuide(options),
                     .freeze = options.freeze.value_or(~0u),
                     .wrap = [&](ImageModel& inner) {
                         std::unique_ptr<BatchedModel> model = batchedModel(options, inner);
                         batched = model.get();
                         return model;
                     }});
    Optimization& run = recovery->optimization();
    ImageModel& model = recovery->model();
    Checkpoints checkpoints(effective, std::move(identity), report.device + ", " + report.driver, log);
    const std::optional<Checkpoint> start = checkpoints.find();
    RunFolder folder(output, start ? std::span<const StepRecord>(start->state.history) : std::span<const StepRecord>());
    folder.writeTargets(run);
    const Values startValues = valuesOf(run);
    if (start) {
        resume(*start, run, model);
        for (const StepRecord& step : start->state.history)
            addStep(report, step);
    }
    recovery->prepareStep();
    log.info(start ? "resumed" : "started", options.input, {{"steps", double(options.recovery.steps)}, {"seconds", report.elapsed()}});
    std::vector<std::string> failures; // to write
    folder.tolerate([&](const Error& error) {
        failures.push_back(error.what());
        log.warn("write_failed", std::string(error.what()) + (error.cause.empty() ? "" : ": " + error.cause) + ". The run goes on in memory");
    });

    RunLog runLog(log, options.recovery.steps);
    Progress progress(std::cerr, isatty(STDERR_FILENO) != 0, options.recovery.steps);
    double lastStep = report.elapsed();
    const auto afterStep = [&](const StepReport& step) {
        const double now = report.elapsed(), taken = now - std::exchange(lastStep, now);
        const StepAgreement agreed = agreeAfterStep(step.loss, options.timeBudget && now + taken > double(*options.timeBudget), stopRequested());
        if (agreed.timeUp)
            run.stopAfter(step.step + 1);
        stop = agreed.stop;
        log.setStep(step.step + 1);
        addStep(report, recordOf(step));
        folder.appendStep(step);
        checkpoints.afterStep(run, model);
        runLog.afterStep(step, session.renderer().statistics(), report, session.device().memory());
        showStep(run, display);
        if (step.step == 0)
            for (std::size_t p = 0; p < session.parameters.size(); ++p)
                warnUnreached(session.scene.parameters[session.parameters[p]].name, step.gradientNorm[p] > 0);
        if (!options.quiet)
            progress.update(step);
    };
    bool done = false;
    std::optional<Error> failure;
    try {
        done = run.run(afterStep);
    } catch (const Error& e) {
        failure = e; // the state is that after a whole step: worth keeping
    }
    if (!options.quiet)
        progress.finish();

    log.setStep(run.state().step);
    checkpoints.write(run, model);
    folder.attempt([&] {
        session.record([&](Options& o) {
            if (std::exchange(o.timeBudget, {}))
                o.stopAfter = run.state().step;
        });
    });
    folder.writeLosses(run.state().history);
    folder.writeScene(run);
    if (failure && failure->kind != ErrorKind::Numerical) { // no device, no pictures
        failure->remedy += (failure->remedy.empty() ? "" : ". ") + ("--resume " + folder.path().string() + " goes on from here");
        log.warn("failed", failure->what());
        throw *failure;
    }
    constexpr std::uint32_t kPictureFactor = 4, kLeastPictureSpp = 64; // pictures to keep deserve more samples than those a step throws away
    guided.passes().setLearning(false);
    writePictures(run, model, folder, startValues, std::max(kLeastPictureSpp, options.effectiveSpp() * kPictureFactor));
    for (const auto& [name, path] : folder.outputs())
        report.outputs.emplace_back(name, path.string());
    folder.attempt([&] { writeContactSheet(options, run, startValues, folder, views, report); });
    folder.attempt([&] { guided.finish(); });
    session.finish();
    log.info(done ? "finished" : "interrupted", "results written", {{"failed_writes", double(failures.size())}});
    if (failure)
        throw *failure;
    if (!failures.empty())
        throw Error(ErrorKind::Output, "not everything could be written: " + failures.back(), "the disk is full, or the folder read-only or gone",
                    "make room and run again with --resume " + folder.path().string());
    if (!options.quiet)
        textOut(options) << "wrote " << (folder.path() / "contact_sheet.png").string() << '\n';
    if (!done)
        return ExitStatus::Interrupted;
    return batched ? tellErrors(options, report, *batched) : ExitStatus::Done;
}

} // namespace cmpg
