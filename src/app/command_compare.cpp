// compare: sampling methods side by side, for derivative images, gradients and whole optimisations; a report in a folder.
#include "app/commands.h"
#include "app/status_line.h"
#include "lab/compare.h"

#include <cmath>
#include <iostream>

namespace cmpg {
namespace {

void printTable(std::ostream& out, const nlohmann::ordered_json& table) {
    const auto number = [](const nlohmann::ordered_json& row, const char* key) {
        return row.contains(key) && row[key].is_number() ? row[key].get<double>() : std::nan("");
    };
    char line[240];
    for (const auto& row : table) {
        const std::string method = row["method"];
        char ratio[32] = ""; // of what never varies there is none
        if (!std::isnan(number(row, "ratio")))
            std::snprintf(ratio, sizeof ratio, "   %7.2f x", number(row, "ratio"));
        if (method == "reference")
            std::snprintf(line, sizeof line, "%-9s reference: relative squared error %.3g, %.1f s\n", row["mode"].get<std::string>().c_str(),
                          number(row, "relative_error"), number(row, "seconds"));
        else if (row["mode"] == "optimize")
            std::snprintf(line, sizeof line, "optimize  %-24s %6.0f steps %8.1f s   parameter MSE %10.4g%s\n", method.c_str(),
                          number(row, "steps"), number(row, "seconds"), number(row, "mse"), ratio);
        else if (std::isnan(number(row, "relative_variance")))
            std::snprintf(line, sizeof line, "%-9s %-24s %6.0f passes %7.1f s   no derivative to compare with\n", row["mode"].get<std::string>().c_str(), method.c_str(),
                          number(row, "passes"), number(row, "seconds"));
        else
            std::snprintf(line, sizeof line, "%-9s %-24s %6.0f passes %7.1f s   rel. variance %9.3g   bias %+7.2f %% +- %.2f %%%s%s\n",
                          row["mode"].get<std::string>().c_str(), method.c_str(), number(row, "passes"), number(row, "seconds"),
                          number(row, "relative_variance"), 100 * number(row, "bias"), 100 * number(row, "bias_95"),
                          row["biased"].get<bool>() ? " BIASED" : "", ratio);
        out << line;
    }
}

} // namespace

ExitStatus runCompare(const Options& options, Report& report) {
    {
        StatusLine status(options);
        compare(options, report, std::ref(status));
    }
    printTable(textOut(options), report.extra["table"]);
    if (!options.quiet)
        textOut(options) << "wrote " << (std::filesystem::path(options.output) / "report.html").string() << '\n';
    return ExitStatus::Done;
}

} // namespace cmpg
