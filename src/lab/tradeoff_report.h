// What a trade-off measurement found: tables, a plot, a page.
#pragma once

#include "lab/pareto_plot.h"
#include "lab/tradeoff_measure.h"

namespace cmpg {

struct TradeoffReport {
    std::vector<SettingResult> singles;   // one knob at a time; the first: the defaults
    std::vector<SettingResult> combined;  // the defaults again, the best changes alone and together, by other random numbers; may be empty
    MeasuredReference reference;
    std::vector<std::string> unused;      // knobs that would change nothing here
    double horizon = 60;                  // seconds after which settings are compared
    double seconds = 0;                   // that all of it took
};

// A row per setting: kTradeoffColumns.
std::string tradeoffCsv(const TradeoffReport& report);
inline constexpr const char* kTradeoffColumns =
    "part,setting,passes,seconds_per_pass,train_seconds,relative_variance,relative_variance_error,bias,bias_95,biased,error_of_pass,"
    "error_at_horizon,gain,gain_log_error,advantage,frontier,chosen\n";

ParetoPlot tradeoffPlot(const TradeoffReport& report);
// The same tables as text, for a document.
std::string tradeoffMarkdown(const TradeoffReport& report);
std::string tradeoffDocument(const CompareSubject& subject, const std::string& device, const std::string& configuration, const TradeoffReport& report);
nlohmann::ordered_json tradeoffTable(const TradeoffReport& report);

} // namespace cmpg
