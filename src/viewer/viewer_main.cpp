// The entry of the window's module.
#include "app/explain.h"
#include "app/viewer_module.h"
#include "viewer/viewer.h"

extern "C" __attribute__((visibility("default"))) int cmpgViewerMain(const cmpg::Options& options) {
    return int(cmpg::explainErrors([&] { return cmpg::viewer::runViewer(options); }));
}
