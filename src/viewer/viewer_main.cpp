// The entry of the window's module.
#include "app/explain.h"
#include "app/viewer_module.h"
#include "base/log.h"
#include "viewer/viewer.h"

extern "C" __attribute__((visibility("default"))) int cmpgViewerMain(const cmpg::Options& options) {
    cmpg::setQuiet(options.quiet); // the module has a log of its own
    return int(cmpg::explainErrors([&] { return cmpg::viewer::runViewer(options); }));
}
