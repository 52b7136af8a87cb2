// What a run did: times, memory, outputs; printed as one JSON object with --json.
#include "session/report.h"

#include "base/log.h"
#include "session/output.h"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <sys/resource.h>
#include <unistd.h>

namespace cmpg {
namespace {

std::string shown(const nlohmann::ordered_json& value) {
    if (value.is_string())
        return value.get<std::string>();
    if (!value.is_array())
        return value.dump();
    std::string list;
    for (const auto& element : value)
        list += (list.empty() ? "" : ", ") + shown(element);
    return list;
}

} // namespace

Report::Report(const Options& options)
    : command(commandName(options.command)), spp(options.effectiveSpp()), seed(options.seed), budgetBytes(options.memory << 20) {}

void Report::addDevice(const Device& dev) {
    device = dev.info().name;
    driver = dev.info().driver;
    kernels = dev.kernelTimes();
    kernelsTimed = dev.timesKernels();
    seconds.compile = dev.compileSeconds();
    devicePeakBytes = dev.memory().peak;
}

void Report::add(const v1::PassReport& pass) {
    paths += pass.paths;
    rays += pass.rays;
    for (const auto& [kind, count] : pass.dropped)
        dropped[kind] += count;
    refusedSplits = std::max(refusedSplits, pass.refusedSplits);
    if (pass.depths.empty())
        return;
    auto& depths = extra["guided_by_depth"] = nlohmann::ordered_json::array();
    for (const GuidedDepth& d : pass.depths) {
        const double drawn = double(std::max<std::uint64_t>(1, d.drawn)), guided = double(std::max<std::uint64_t>(1, d.guided));
        depths.push_back({{"directions", d.drawn}, {"guided", double(d.guided) / drawn}, {"dead", double(d.dead) / guided}, {"light_share", d.lightShare / drawn}});
    }
}

void Report::warnOfLosses() const {
    for (const auto& [kind, count] : dropped)
        if (count > 0)
            logWarn(std::to_string(count) + " contributions dropped: " + kind, "dropped");
    if (refusedSplits > 0)
        logWarn("the guide is coarser than its records allow: " + std::to_string(refusedSplits) + " splits were refused for want of memory; raise --guide-memory", "guide_full");
}

nlohmann::ordered_json Report::toJson() const {
    nlohmann::ordered_json json;
    json["command"] = command;
    json["device"] = device;
    json["driver"] = driver;
    json["width"] = width;
    json["height"] = height;
    json["spp"] = spp;
    json["seed"] = seed;
    json["paths"] = paths;
    json["rays"] = rays;
    json["seconds"] = {{"total", total_.seconds()},     {"load", seconds.load},         {"compile", seconds.compile},
                       {"primal", seconds.primal},      {"gradient", seconds.gradient}, {"guide", seconds.guide},
                       {"optimizer", seconds.optimizer}};
    auto& kernelTimes = json["kernels"] = nlohmann::ordered_json::object();
    for (const auto& [name, time] : kernels) {
        kernelTimes[name] = {{"calls", time.calls}};
        if (kernelsTimed)
            kernelTimes[name]["seconds"] = time.seconds;
    }
    json["memory"] = {{"device_peak_bytes", devicePeakBytes},
                      {"host_peak_bytes", hostPeakBytes()},
                      {"budget_bytes", budgetBytes},
                      {"refused_splits", refusedSplits}};
    auto& left = json["dropped"] = nlohmann::ordered_json::object();
    for (const auto& [kind, count] : dropped)
        left[kind] = count;
    json["loss"] = loss;
    auto& paths_ = json["outputs"] = nlohmann::ordered_json::object();
    for (const auto& [name, path] : outputs)
        paths_[name] = path;
    for (const auto& [key, value] : extra.items())
        json[key] = value;
    return json;
}

std::uint64_t hostPeakBytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return std::uint64_t(usage.ru_maxrss) * 1024; // Linux counts in KiB
}

std::uint64_t hostBytes() {
    std::ifstream statm("/proc/self/statm");
    std::uint64_t all = 0, resident = 0;
    statm >> all >> resident;
    return resident * std::uint64_t(sysconf(_SC_PAGESIZE));
}

std::ostream& textOut(const Options& options) {
    return options.json ? std::cerr : std::cout;
}

void printConfiguration(const Options& options) {
    if (options.quiet)
        return;
    std::ostream& out = textOut(options);
    const nlohmann::ordered_json config = toConfig(options);
    for (const auto& [key, value] : config.items()) {
        std::string line = "  " + key;
        line.resize(std::max<std::size_t>(line.size() + 2, 20), ' ');
        out << line << shown(value) << '\n';
    }
    out.flush();
}

void writeRunJson(const Options& options, const std::filesystem::path& folder, Report& report) {
    nlohmann::ordered_json json = toConfig(options);
    json["made-with"] = {{"version", CMPG_VERSION}, {"device", report.device}, {"driver", report.driver}};
    const std::filesystem::path file = folder / "run.json";
    writeTextFile(file, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    const std::pair<std::string, std::string> output{"run", file.string()};
    if (std::find(report.outputs.begin(), report.outputs.end(), output) == report.outputs.end())
        report.outputs.push_back(output);
}

} // namespace cmpg
