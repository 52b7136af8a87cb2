// The guide of an optimisation: loaded and saved as the options say.
#include "session/guided_session.h"

#include "base/communicator.h"
#include "render/saved_guide.h"

namespace cmpg {
namespace {

const char* samplingName(Sampling sampling) {
    for (const auto& s : kSamplings)
        if (s.value == sampling)
            return s.name;
    return "";
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

void tellSampling(const Options& options, Report& report, Sampling kind, bool roulette, std::span<const MethodFigures> figures) {
    auto plain = nlohmann::ordered_json::object(), with = plain;
    for (const MethodFigures& f : figures)
        (f.roulette ? with : plain)[samplingName(f.sampling)] = {{"variance", f.variance}, {"rays_per_path", f.raysPerPath}, {"passes", f.passes}};
    report.extra["sampling"] = {{"kind", samplingName(kind)}, {"roulette", roulette}, {"figures", plain}, {"roulette_figures", with}};
    if (!usesGuide(options) || options.quiet)
        return;
    textOut(options) << "  drawn by          " << samplingName(kind) << (roulette ? ", roulette and splitting" : "") << '\n';
    for (const MethodFigures& f : figures)
        textOut(options) << "    " << samplingName(f.sampling) << (f.roulette ? " + roulette" : "") << ": variance " << f.variance << ", " << f.raysPerPath
                         << " rays a path\n";
}

GuidedSession::GuidedSession(const Options& options, Report& report, Session& session, GuidedPasses& passes)
    : options_(options), report_(report), session_(session), passes_(passes) {
    if (!options.loadGuide.empty() && usesGuide(options))
        passes_.load(readGuide(options.loadGuide, session.scene, &session.parameters));
}

void GuidedSession::finish() {
    report_.seconds.guide += passes_.trainSeconds();
    const SamplingDecision decision = passes_.decision();
    tellSampling(options_, report_, decision.method.kind, decision.method.roulette, figuresOf(decision));
    if (options_.saveGuide.empty() || !ranks().isRoot())
        return;
    writeGuide(options_.saveGuide, session_.scene, session_.parameters, session_.renderer(), passes_);
    report_.outputs.emplace_back("guide", options_.saveGuide);
}

} // namespace cmpg
