// What a trade-off measurement found: tables, a plot, a page.
#include "lab/tradeoff_report.h"

#include "imaging/html.h"
#include "imaging/number_text.h"
#include "lab/compare_pictures.h"
#include "lab/compare_report.h"
#include "lab/error_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace cmpg {
namespace {

std::string percent(double fraction, const char* format = "%.3g %%") {
    char text[32];
    std::snprintf(text, sizeof text, format, 100 * fraction);
    return std::isfinite(fraction) ? text : "-";
}

std::string number(double value) { return std::isfinite(value) ? threeDigits(value) : "-"; }

// "1.32 x (1.20 to 1.45)": with the interval of two standard errors of the logarithm.
std::string factor(const Uncertain& gain) {
    char text[64];
    std::snprintf(text, sizeof text, "%.2f (%.2f to %.2f)", gain.value, gain.value * std::exp(-2 * gain.error), gain.value * std::exp(2 * gain.error));
    return std::isfinite(gain.value) && std::isfinite(gain.error) ? (gain.error > 0 ? text : "1") : "-";
}

std::string biasText(const Bias& bias) {
    if (!std::isfinite(bias.along))
        return "-";
    return percent(bias.along, "%+.2g %%") + " ± " + percent(bias.interval) + (bias.verdict == Bias::Verdict::Biased ? ", biased" : "");
}

struct Row {
    const char* part;
    const SettingResult* result;
    const SettingResult* first;
    bool edge;
};

std::vector<Row> rowsOf(const TradeoffReport& report) {
    std::vector<Row> rows;
    for (const auto& [part, results] : {std::pair("single", &report.singles), std::pair("combined", &report.combined)}) {
        const std::vector<std::size_t> edge = frontier(*results);
        for (std::size_t i = 0; i < results->size(); ++i)
            rows.push_back({part, &(*results)[i], &results->front(), std::find(edge.begin(), edge.end(), i) != edge.end()});
    }
    return rows;
}

const std::vector<std::string> kHeads = {"setting",        "seconds of a pass", "relative variance", "bias",    "error of a pass",
                                         "after a minute", "efficiency",        "time for the same error", "frontier"};

// `time`: what the setting takes for the error that the defaults have at the horizon, over what they take.
std::vector<std::string> cells(const Row& row, double horizon) {
    const SettingResult& r = *row.result;
    const double gain = advantage(r, *row.first, horizon);
    return {r.setting.name(), number(r.secondsPerPass), number(r.relativeVariance.value) + " ± " + number(r.relativeVariance.error), biasText(r.bias),
            percent(r.errorOfPass()), percent(r.errorAfter(horizon)), factor(r.gain), gain > 0 ? number(1 / gain) : "never", row.edge ? "yes" : ""};
}

std::string heading(const TradeoffReport& report, std::size_t column) {
    return column == 5 ? "error after " + number(report.horizon) + " s" : kHeads[column];
}

HtmlTable table(const TradeoffReport& report, const std::string& part) {
    HtmlTable html;
    const char* kMeanings[] = {"What differs from the defaults",
                               "Learning excluded",
                               "Of one pass: summed over all entries, over the squared length of the result; with one standard error over trainings",
                               "Along the reference, with the 95 % interval",
                               "Root of relative variance plus squared bias, where one was seen",
                               "The same for the mean of as many passes as fit",
                               "1 / (variance x seconds), over that of the defaults; with two standard errors",
                               "As long as the defaults take: 1; what is biased may never get there",
                               "No other setting has a smaller error in less time a pass"};
    for (std::size_t i = 0; i < kHeads.size(); ++i)
        html.columns.push_back({heading(report, i), kMeanings[i]});
    for (const Row& row : rowsOf(report)) {
        if (row.part != part)
            continue;
        std::vector<std::string> line;
        for (const std::string& cell : cells(row, report.horizon))
            line.push_back(escapeHtml(cell));
        line[0] = (row.edge ? "<b>" : "") + line[0] + (row.edge ? "</b>" : "");
        if (!row.result->chosen.empty())
            line[0] += "<span class=\"how\">chosen: " + escapeHtml(row.result->chosen) + "</span>";
        html.rows.push_back(std::move(line));
    }
    return html;
}

// What each change on the frontier costs when it is left out: from the defaults that have it, or from the combination.
std::vector<std::string> costs(const TradeoffReport& report) {
    std::vector<std::string> lines;
    if (!(report.reference.reference.squaredNorm() > 0)) // every error is of nothing
        return lines;
    const auto add = [&](const std::string& what, double times, const std::string& how) {
        char text[96];
        std::snprintf(text, sizeof text, "%.3g times the time", times);
        lines.push_back(what + ": " + (times > 0 ? text : "the error is never reached") + how);
    };
    if (report.combined.size() > 1) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < report.combined.size(); ++i)
            if (advantage(report.combined[i], report.combined.front(), report.horizon) >
                advantage(report.combined[best], report.combined.front(), report.horizon))
                best = i;
        const SettingResult& all = report.combined[best];
        const double gain = advantage(all, report.combined.front(), report.horizon);
        const bool several = all.setting.changes.size() > 1;
        if (best > 0)
            add((several ? "all of " : "") + all.setting.name(), gain, " when left out");
        if (best > 0 && several)
            for (const KnobChange& change : all.setting.changes)
                for (const SettingResult& rest : report.combined) {
                    const auto& kept = rest.setting.changes;
                    const bool without = kept.size() + 1 == all.setting.changes.size() &&
                                         std::all_of(kept.begin(), kept.end(), [&](const KnobChange& k) {
                                             return k.option != change.option && std::any_of(all.setting.changes.begin(), all.setting.changes.end(),
                                                                                             [&](const KnobChange& a) { return a.text() == k.text(); });
                                         });
                    const double left = without ? advantage(rest, report.combined.front(), report.horizon) : 0;
                    if (without)
                        add(change.text(), left > 0 ? gain / left : 0, " when left out of " + all.setting.name());
                }
    }
    std::map<std::string, double> best; // of the alternatives of each part of the defaults
    for (std::size_t i = 1; i < report.singles.size(); ++i) {
        const SettingResult& r = report.singles[i];
        if (r.setting.changes.front().option == "quality") // which sets other knobs
            continue;
        double& most = best[r.setting.changes.front().option];
        most = std::max(most, advantage(r, report.singles.front(), report.horizon));
    }
    for (const auto& [option, gain] : best)
        if (gain < 1)
            add("the default of --" + option, gain > 0 ? 1 / gain : 0, " with the best other value");
    return lines;
}

std::string headline(const TradeoffReport& report) {
    std::string names;
    for (const std::size_t i : frontier(report.singles))
        names += (names.empty() ? "" : ", ") + report.singles[i].setting.name();
    return names;
}

std::string referenceText(const TradeoffReport& report) {
    return "The reference is the mean of " + std::to_string(report.reference.passes) + " passes of " + report.reference.madeBy +
           "; its squared error is " + number(report.reference.reference.relativeError()) + " of its squared length.";
}

} // namespace

std::string tradeoffCsv(const TradeoffReport& report) {
    std::string csv = kTradeoffColumns;
    for (const Row& row : rowsOf(report)) {
        const SettingResult& r = *row.result;
        csv += csvLine({row.part, r.setting.name(), std::to_string(r.passes), csvNumber(r.secondsPerPass), csvNumber(r.trainSeconds),
                        csvNumber(r.relativeVariance.value), csvNumber(r.relativeVariance.error), csvNumber(r.bias.along), csvNumber(r.bias.interval),
                        r.bias.verdict == Bias::Verdict::Biased ? "1" : "0", csvNumber(r.errorOfPass()), csvNumber(r.errorAfter(report.horizon)),
                        csvNumber(r.gain.value), csvNumber(r.gain.error), csvNumber(advantage(r, *row.first, report.horizon)), row.edge ? "1" : "0", r.chosen});
    }
    return csv;
}

nlohmann::ordered_json tradeoffTable(const TradeoffReport& report) {
    auto table = nlohmann::ordered_json::array();
    for (const Row& row : rowsOf(report)) {
        const SettingResult& r = *row.result;
        table.push_back({{"part", row.part},
                         {"setting", r.setting.name()},
                         {"passes", r.passes},
                         {"seconds_per_pass", r.secondsPerPass},
                         {"relative_variance", r.relativeVariance.value},
                         {"bias", r.bias.along},
                         {"bias_95", r.bias.interval},
                         {"biased", r.bias.verdict == Bias::Verdict::Biased},
                         {"error_of_pass", r.errorOfPass()},
                         {"gain", r.gain.value},
                         {"gain_log_error", r.gain.error},
                         {"advantage", advantage(r, *row.first, report.horizon)},
                         {"frontier", row.edge},
                         {"chosen", r.chosen}});
    }
    return table;
}

ParetoPlot tradeoffPlot(const TradeoffReport& report) {
    ParetoPlot plot;
    plot.title = "Error of a pass against its time";
    plot.across = "seconds of a pass";
    plot.up = "relative error of a pass";
    std::vector<SettingResult> shown = report.singles;
    for (const SettingResult& r : report.combined)
        if (r.setting.changes.size() > 1)
            shown.push_back(r);
    std::vector<std::string> groups{""};
    for (const SettingResult& r : shown) {
        const std::string group = r.setting.changes.empty() ? "" : r.setting.changes.size() > 1 ? "+" : r.setting.changes.front().option;
        const auto found = std::find(groups.begin(), groups.end(), group);
        const auto index = std::size_t(found - groups.begin());
        if (found == groups.end())
            groups.push_back(group);
        plot.points.push_back({r.setting.name(), r.secondsPerPass, r.errorOfPass(), index, r.squaredBias > 0});
    }
    plot.frontier = frontier(shown);
    return plot;
}

std::string tradeoffMarkdown(const TradeoffReport& report) {
    std::string text;
    for (const std::string part : {"single", "combined"}) {
        if (part == "combined" && report.combined.empty())
            continue;
        text += part == "single" ? "One knob at a time:\n\n|" : "\nTogether:\n\n|";
        for (std::size_t i = 0; i < kHeads.size(); ++i)
            text += " " + heading(report, i) + " |";
        text += "\n|";
        for (std::size_t i = 0; i < kHeads.size(); ++i)
            text += "---|";
        for (const Row& row : rowsOf(report)) {
            if (row.part != part)
                continue;
            std::vector<std::string> line = cells(row, report.horizon);
            text += "\n| `" + line[0] + "` |";
            for (std::size_t i = 1; i < line.size(); ++i)
                text += " " + line[i] + " |";
        }
        text += "\n";
    }
    text += "\nLeft out:\n\n";
    for (const std::string& line : costs(report))
        text += "- " + line + "\n";
    text += "\n" + referenceText(report) + "\n";
    return text;
}

std::string tradeoffDocument(const CompareSubject& subject, const std::string& device, const std::string& configuration, const TradeoffReport& report) {
    const std::filesystem::path scene = std::filesystem::absolute(subject.options.input).lexically_normal();
    const std::string name = (scene.parent_path().filename() / scene.filename()).string();
    const char* what = subject.modes.front() == CompareMode::Forward ? "Derivative image by "
                       : subject.steps                               ? "Gradient of a step of a recovery, image and derivative pass, by "
                                                                     : "Gradient by ";
    std::string body = "<h1>" + escapeHtml(name) + ": speed against accuracy</h1>\n<p class=\"lead\">" + what + "<code>" + escapeHtml(subject.parameterNames()) + "</code>, " +
                       std::to_string(subject.view.width) + " &times; " + std::to_string(subject.view.height) + " pixels, on " + escapeHtml(device) +
                       ", measured in " + shortNumber(report.seconds) + " s.</p>\n<section>\n<h2>One knob at a time</h2>\n<p class=\"result\">On the frontier: <b>" +
                       escapeHtml(headline(report)) + "</b>.</p>\n<div class=\"plot\">" + svgImage(tradeoffPlot(report).svg()) + "</div>\n" +
                       htmlTable(table(report, "single"));
    if (!report.unused.empty()) {
        std::string list;
        for (const std::string& option : report.unused)
            list += (list.empty() ? "--" : ", --") + option;
        body += "<p>Not varied, as nothing here depends on them: <code>" + escapeHtml(list) + "</code>.</p>\n";
    }
    body += "</section>\n";
    if (!report.combined.empty())
        body += "<section>\n<h2>Together</h2>\n<p>The best changes, alone and together, with random numbers and trainings of their own: what was among "
                "the best by chance is not so here again.</p>\n" +
                htmlTable(table(report, "combined")) + "</section>\n";
    body += "<section>\n<h2>What each costs when left out</h2>\n<ul>\n";
    for (const std::string& line : costs(report))
        body += "<li>" + escapeHtml(line) + "</li>\n";
    body += "</ul>\n<p>Times are for the error that the defaults have after " + shortNumber(report.horizon) +
            " s.</p></section>\n<details><summary>How to read this</summary>\n<p>Every setting estimates the same derivative again and again, from several "
            "trainings of its own guide. Its error has two parts: variance, which falls with time, and bias, which stays. Efficiency counts "
            "variance alone; the time for the same error counts both. Settings take turns, so that a drift of the machine hits all alike. A setting "
            "is biased where the difference from the reference is beyond chance at 99.9 %; a bias below the stated interval cannot show. The "
            "time of learning is in none of the figures but those of the CSV file.</p>\n<p>" +
            escapeHtml(referenceText(report)) + " It has the largest depth of all settings.</p></details>\n<details><summary>Options of this run</summary><p><code>" +
            escapeHtml(configuration) + "</code></p></details>\n";
    return htmlDocument(name + ": speed against accuracy", body);
}

} // namespace cmpg
