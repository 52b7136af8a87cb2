// The compiled half of cmpg.lab: measurements of the command line, with its options as a run.json has them. Apart from _cmpg, since their pictures need
// Cairo. python/cmpg/lab.py is the surface.
#include "errors.h"

#include "lab/compare.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

// `options`: JSON, "command" included. Returns the report, as --json prints it. `progress`: called with what is being done, or None.
std::string measure(const std::string& options, const std::string& output, nb::handle progress) {
    const nb::gil_scoped_release released;
    cmpg::Options o;
    cmpg::applyConfig(nlohmann::json::parse(options), o);
    o.output = output;
    o.quiet = o.headless = true;
    cmpg::validate(o);
    cmpg::Report report(o);
    const auto tell = [&](const std::string& text) { // Ctrl-C ends a measurement after a pass
        const nb::gil_scoped_acquire gil;
        if (PyErr_CheckSignals() != 0)
            throw nb::python_error();
        if (!progress.is_none())
            progress(text);
    };
    if (o.command == cmpg::Command::Compare)
        cmpg::compare(o, report, tell);
    else
        cmpg::tradeoff(o, report, tell);
    return report.toJson().dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

} // namespace

NB_MODULE(_lab, m) {
    nb::register_exception_translator(translate);
    m.def("measure", &measure, "options"_a, "output"_a, "progress"_a.none());
}
