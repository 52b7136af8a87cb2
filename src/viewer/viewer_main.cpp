// The entry of the window's module.
#include "session/explain.h"
#include "viewer/viewer.h"
#include "viewer/viewer_main.h"

extern "C" __attribute__((visibility("default"))) int cmpgViewerMain(const cmpg::Options& options) {
    return int(cmpg::explainErrors([&] { return cmpg::viewer::runViewer(options); }));
}
