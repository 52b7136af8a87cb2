// The compiled half of the Python package: handles of the library, with arrays in place of its vectors. python/cmpg/ is the surface.
#include "errors.h"
#include "handles.h"

NB_MODULE(_cmpg, m) {
    nb::register_exception_translator(translate);
    bindScene(m);
    bindRenderer(m);
    bindGuide(m);
    bindRecovery(m);
    m.attr("__version__") = CMPG_VERSION;
}
