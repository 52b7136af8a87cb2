// render: an image of the scene, and layers of what the camera sees.
#include "app/commands.h"
#include "app/display.h"
#include "base/communicator.h"
#include "session/output.h"
#include "session/render_session.h"

namespace cmpg {

ExitStatus runRender(const Options& options, Report& report) {
    requireWritableFile(options.output, ".exr");
    if (!options.layers.empty())
        requireWritableFile(options.layers, ".exr");
    requireWritableGuide(options.saveGuide);
    RenderSession session(options, report);
    session.prepare(viewOf(options, session.host(), ""), folderOf(options.output), {v1::PassKind::Render});

    DisplayStream display(options.displayServer, displayTitle(options));
    v1::PassOptions pass = session.pass(options.effectiveSpp());
    pass.onImage = shownIn(display, "image");
    v1::PassReport done;
    const Image image = session.renderer().render(pass, &done);
    session.add(done);
    report.seconds.primal = done.seconds;
    const ExitStatus code = session.conclude(done, &Options::spp);

    if (ranks().isRoot())
        writeExr(options.output, image);
    report.outputs.emplace_back("image", options.output);
    session.tell(done);
    session.finish(&image);
    return code;
}

} // namespace cmpg
