// tradeoff: which options trade speed for accuracy on a scene, which of them are on the frontier, and what each costs when left out.
#include "app/commands.h"
#include "app/status_line.h"
#include "lab/compare.h"

#include <iostream>

namespace cmpg {

ExitStatus runTradeoff(const Options& options, Report& report) {
    std::string tables;
    {
        StatusLine status(options);
        tables = tradeoff(options, report, std::ref(status));
    }
    if (!options.quiet)
        textOut(options) << tables << "wrote " << (std::filesystem::path(options.output) / "report.html").string() << '\n';
    return ExitStatus::Done;
}

} // namespace cmpg
