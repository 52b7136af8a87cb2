// render: an image of the scene, and layers of what the camera sees.
#include "app/commands.h"
#include "app/display.h"
#include "base/communicator.h"
#include "imaging/layers_file.h"
#include "lab/batched_passes.h"
#include "session/guided_session.h"
#include "session/output.h"
#include "session/session.h"

namespace cmpg {

ExitStatus runRender(const Options& options, Report& report) {
    requireWritableFile(options.output, ".exr");
    if (!options.layers.empty())
        requireWritableFile(options.layers, ".exr");
    Session session(options, report);
    const View view = viewOf(options, session.scene, "");
    session.prepare(view, folderOf(options.output), {Renderer::Mode::Render}, !options.layers.empty());

    GuidedSession guided(options, report, session);
    guided.train([&](std::uint32_t passes) { guided.passes().trainRender(view, options.effectiveTrainSpp(), passes, options.seed); });
    guided.passes().prepareNext(Renderer::Mode::Render, !options.layers.empty());
    const Stopwatch watch;
    Layers layers;
    Image image;
    const PassKey key{.seed = options.seed};
    ExitStatus code = ExitStatus::Done;
    DisplayStream display(options.displayServer, displayTitle(options));
    if (const std::uint32_t batches = options.effectiveBatches()) {
        const BudgetedEstimate estimate = spendBudget(
            sampleBudget(options, report, options.effectiveSpp()),
            [&](const BatchPart& part) { return fromImage(guided.passes().render(view, part.samples, partKey(key, part, batches, true))); },
            [&](const BudgetedEstimate& e) {
                if (display.active())
                    display.show("image", toImage(e.mean, view.width, view.height));
            });
        image = toImage(estimate.mean, view.width, view.height);
        code = conclude(estimate, options, report, session, &Options::spp);
    } else if (display.active()) {
        Film film(view.width, view.height, !options.layers.empty());
        showGrowing(display, "image", film, options.effectiveSpp(), [&](std::uint32_t spp) { guided.passes().render(view, spp, key, film); });
        image = film.image();
        layers = film.layers();
    } else {
        image = guided.passes().render(view, options.effectiveSpp(), key, options.layers.empty() ? nullptr : &layers);
    }
    report.seconds.primal = watch.seconds();

    if (ranks().isRoot()) {
        writeExr(options.output, image);
        report.outputs.emplace_back("image", options.output);
        if (!options.layers.empty()) {
            writeLayers(options.layers, layers, usesGuide(options));
            report.outputs.emplace_back("layers", options.layers);
        }
    }
    guided.finish();
    session.finish(&image);
    return code;
}

} // namespace cmpg
