// The guide of a command: learned, loaded and saved as the options say.
#include "session/guided_session.h"

#include "base/communicator.h"
#include "base/error.h"

#include <algorithm>

namespace cmpg {
namespace {

const char* samplingName(Sampling sampling) {
    for (const auto& s : kSamplings)
        if (s.value == sampling)
            return s.name;
    return "";
}

std::vector<std::string> parameterNames(const Session& session) {
    std::vector<std::string> names;
    for (const std::uint32_t p : session.parameters)
        names.push_back(session.scene.parameters[p].name);
    std::sort(names.begin(), names.end());
    return names;
}

nlohmann::ordered_json figuresOf(const std::map<Sampling, SamplingFigures>& figures) {
    auto json = nlohmann::ordered_json::object();
    for (const auto& [kind, f] : figures)
        json[samplingName(kind)] = {{"variance", f.variance}, {"rays_per_path", f.rays}, {"passes", f.passes}};
    return json;
}

} // namespace

GuidedOptions guidedOptions(const Options& options) {
    return {.sampling = options.sampling,
            .pixels = options.pixelSampling.value_or(PixelSampling::Adjoint),
            .positivize = options.positivize,
            .roulette = options.roulette,
            .immediate = !options.saveGuide.empty()};
}

GuidedOptions sessionOptions(const Options& options) {
    GuidedOptions guided = guidedOptions(options);
    guided.roulette &= options.isReverse();
    return guided;
}

bool usesGuide(const Options& options) {
    const bool wanted = options.sampling != Sampling::Bsdf || (options.roulette && options.isReverse()) || !options.saveGuide.empty();
    return wanted && (options.command == Command::Optimize || options.effectiveTrain() > 0 || !options.loadGuide.empty());
}

GuidedSession::GuidedSession(const Options& options, Report& report, Session& session)
    : options_(options), report_(report), session_(session),
      own_(std::make_unique<GuidedPasses>(session.renderer(), sessionOptions(options))), passes_(*own_) {
    load();
}

GuidedSession::GuidedSession(const Options& options, Report& report, Session& session, GuidedPasses& passes)
    : options_(options), report_(report), session_(session), passes_(passes) {
    load();
}

void GuidedSession::load() {
    const Options& options = options_;
    Session& session = session_;
    if (options.loadGuide.empty() || !usesGuide(options))
        return;
    LoadedGuide guide = loadGuide(options.loadGuide);
    if (guide.context.geometry != geometryHash(session.scene))
        throw Error(ErrorKind::Input, "'" + options.loadGuide + "' was learned in another scene", "the scene's triangles are not those of the guide",
                    "use the scene it was saved with, or learn a new one with --train and --save-guide");
    std::vector<std::string> names = guide.context.parameters;
    std::sort(names.begin(), names.end());
    if (options.command != Command::Render && names != parameterNames(session)) // an image needs no derivatives
        throw Error(ErrorKind::Input, "'" + options.loadGuide + "' was learned for other parameters",
                    names.empty() ? "it was saved by a run without --param" : "it was saved for " + names.front() + (names.size() > 1 ? " and others" : ""),
                    "name the same --param, or learn a new one with --train and --save-guide");
    passes_.load(std::move(guide));
}

void GuidedSession::train(const std::function<void(std::uint32_t)>& run) {
    if (options_.effectiveTrain() > 0 && usesGuide(options_))
        run(options_.effectiveTrain());
}

void GuidedSession::finish() {
    report_.seconds.guide += passes_.trainSeconds();
    const SamplingDecision decision = options_.command == Command::Render ? passes_.imageDecision() : passes_.decision();
    report_.extra["sampling"] = {{"kind", samplingName(decision.method.kind)},
                                 {"roulette", decision.method.roulette},
                                 {"figures", figuresOf(decision.figures)},
                                 {"roulette_figures", figuresOf(decision.rouletteFigures)}};
    if (!usesGuide(options_))
        return;
    if (!options_.quiet) {
        textOut(options_) << "  drawn by          " << samplingName(decision.method.kind) << (decision.method.roulette ? ", roulette and splitting" : "") << '\n';
        for (const auto& [figures, with] : {std::pair(&decision.figures, ""), std::pair(&decision.rouletteFigures, " + roulette")})
            for (const auto& [kind, f] : *figures)
                textOut(options_) << "    " << samplingName(kind) << with << ": variance " << f.variance << ", " << f.rays << " rays a path\n";
    }
    if (options_.saveGuide.empty() || !ranks().isRoot())
        return;
    GuideContext context = passes_.guideContext();
    context.geometry = geometryHash(session_.scene);
    context.parameters = parameterNames(session_);
    saveGuide(options_.saveGuide, session_.renderer().guide(), context);
    report_.outputs.emplace_back("guide", options_.saveGuide);
}

} // namespace cmpg
