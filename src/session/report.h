// What a run did: times, memory, outputs; printed as one JSON object with --json.
#pragma once

#include "base/stopwatch.h"
#include "session/options.h"
#include "vk/device.h"

#include <filesystem>
#include <iosfwd>
#include <nlohmann/json.hpp>

namespace cmpg {

struct Report {
    std::string command;
    std::string device, driver;
    int width = 0, height = 0;
    std::uint32_t spp = 0;
    std::uint64_t seed = 0, paths = 0, rays = 0;
    // Wall seconds until a result is in host memory. `total` is since the report was made.
    struct Seconds {
        double load = 0, compile = 0, primal = 0, gradient = 0, guide = 0, optimizer = 0;
    } seconds;
    std::map<std::string, KernelTime> kernels;
    bool kernelsTimed = false;
    std::uint64_t devicePeakBytes = 0, budgetBytes = 0;
    std::map<std::string, std::uint64_t> dropped;                    // contributions left out, by kind
    std::uint64_t refusedSplits = 0;                                 // of a guide, for want of memory: the most of all renderers
    std::vector<double> loss;                                        // per step
    std::vector<std::pair<std::string, std::string>> outputs;        // name -> path
    nlohmann::ordered_json extra = nlohmann::ordered_json::object(); // what a single command adds

    explicit Report(const Options& options);

    void addDevice(const Device& device); // times and memory as they are now
    void add(const v1::PassReport& pass);          // costs and losses
    void warnOfLosses() const; // contributions dropped and splits refused
    // All fields named in the manual, then `extra`; not finite numbers become null.
    nlohmann::ordered_json toJson() const;

    double elapsed() const { return total_.seconds(); }

  private:
    Stopwatch total_;
};

// Resident memory of this process in bytes: the most so far, and now (0 where the system does not tell).
std::uint64_t hostPeakBytes();
std::uint64_t hostBytes();

// Where text for people goes: stdout, or stderr when stdout is kept for one JSON object.
std::ostream& textOut(const Options& options);

// Prints the effective configuration, unless --quiet.
void printConfiguration(const Options& options);
// Writes run.json into `folder`, again if it is there, and notes it as an output.
void writeRunJson(const Options& options, const std::filesystem::path& folder, Report& report);

} // namespace cmpg
