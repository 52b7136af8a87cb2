// A scene and a renderer of the library's surface as the options want them.
#include "session/render_session.h"

#include "base/communicator.h"
#include "base/log.h"
#include "imaging/layers_file.h"
#include "session/library_options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

// "0.93 % (95 %: 0.88 to 0.99 %)"
std::string describe(const EstimateError& error) {
    if (!std::isfinite(error.relative))
        return "unknown: the estimate is zero";
    char text[96];
    std::snprintf(text, sizeof text, "%.3g %% (95 %%: %.3g to %.3g %%)", 100 * error.relative, 100 * error.low, 100 * error.high);
    return text;
}

} // namespace

void RenderSession::prepare(const SeenView& view, const std::filesystem::path& folder, std::initializer_list<v1::PassKind> kinds) {
    camera_ = view.camera;
    width_ = view.width;
    height_ = view.height;
    const v1::PathOptions paths = pathOptions(options_, options_.effectiveDepth(host().maxDepth));
    if (options_.sampling != Sampling::Bsdf && options_.sampling != Sampling::Auto && !usesGuide(options_))
        logWarn(std::string("nothing was learned to draw directions by (--sampling ") + nameOf(options_.sampling, kSamplings) +
                "), so they come from the materials alone: add --train N or --load-guide FILE");
    renderer_.emplace(openDevice(), scene, v1::RendererOptions{.paths = paths, .parameters = parameters});
    v1::PassOptions pass = plainPass(1);
    pass.train = usesGuide(options_) ? options_.effectiveTrain() : 0;
    pass.layers = !options_.layers.empty();
    renderer_->prepare(kinds, pass);
    begin(view, folder);
}

v1::PassOptions RenderSession::plainPass(std::uint32_t spp) const {
    return {.camera = camera_, .width = width_, .height = height_, .spp = spp, .seed = options_.seed, .strict = false};
}

v1::PassOptions RenderSession::pass(std::uint32_t spp) const {
    v1::PassOptions pass = plainPass(spp);
    pass.train = usesGuide(options_) ? options_.effectiveTrain() : 0;
    pass.trainSpp = options_.effectiveTrainSpp();
    pass.batches = options_.effectiveBatches();
    pass.layers = !options_.layers.empty();
    if (options_.errorTarget)
        pass.errorTarget = double(*options_.errorTarget);
    constexpr double kLeast = 1e-6; // what was before may have taken all
    if (options_.timeBudget)
        pass.timeBudget = std::max(kLeast, double(*options_.timeBudget) - report_.elapsed());
    return pass;
}

void RenderSession::tell(const v1::PassReport& pass) {
    if (!options_.layers.empty() && ranks().isRoot()) {
        writeLayers(options_.layers, pass.layers, pass.guided);
        report_.outputs.emplace_back("layers", options_.layers);
    }
    Session::tell(pass, *renderer_);
}

ExitStatus RenderSession::conclude(const v1::PassReport& pass, std::optional<std::uint32_t> Options::* samples) {
    report_.spp = pass.spp;
    if (pass.batches == 0)
        return ExitStatus::Done;
    const EstimateError& error = pass.error;
    const bool reached = !options_.errorTarget || error.relative <= double(*options_.errorTarget);
    report_.extra["error"] = {{"relative", error.relative}, {"low", error.low},   {"high", error.high}, {"degrees", error.degrees},
                              {"batches", pass.batches},    {"spp", pass.spp},    {"reached", reached}};
    record([&](Options& o) {
        o.*samples = pass.spp;
        o.batches = pass.batches;
        o.timeBudget.reset();
    });
    if (!options_.quiet)
        textOut(options_) << "  error             " << describe(error) << ", " << pass.spp << " samples per pixel in " << pass.batches << " batches\n";
    if (reached)
        return ExitStatus::Done;
    char target[32];
    std::snprintf(target, sizeof target, "%.3g %%", 100 * double(*options_.errorTarget));
    const bool time = pass.end == BudgetEnd::Time;
    logWarn("the error target of " + std::string(target) + " was not reached: the error is " + describe(error) + " after " + std::to_string(pass.spp) +
            " samples per pixel; " + (time ? "allow more --time-budget" : "allow more samples"));
    return ExitStatus::CheckFailed;
}

} // namespace cmpg
