// The object --json prints: its fields and their kinds, whatever the command.
#include "session/report.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(Report, HasExactlyTheDocumentedFields) {
    Options o;
    o.command = Command::Gradient;
    o.spp = 12;
    o.seed = ~std::uint64_t(0);
    o.memory = 512;
    Report report(o);
    report.kernels["trace_closest"] = {3, 0.5};
    report.kernelsTimed = true;
    report.dropped["film.nonfinite"] = 2;
    v1::PassReport statistics;
    statistics.paths = 7;
    statistics.refusedSplits = 3;
    report.add(statistics);
    statistics.refusedSplits = 1; // of another renderer
    report.add(statistics);
    report.loss = {0.5, std::nan("")};
    report.outputs.emplace_back("gradient", "a.exr");
    const nlohmann::json json = nlohmann::json::parse(report.toJson().dump());

    std::vector<std::string> names;
    for (const auto& [key, value] : json.items())
        names.push_back(key);
    EXPECT_EQ(names, (std::vector<std::string>{"command", "device", "driver", "dropped", "height", "kernels", "loss", "memory", "outputs",
                                               "paths", "rays", "seconds", "seed", "spp", "width"})); // in the alphabet's order
    EXPECT_EQ(json["command"], "gradient");
    EXPECT_EQ(json["spp"], 12);
    EXPECT_EQ(json["seed"].get<std::uint64_t>(), ~std::uint64_t(0));
    names.clear();
    for (const auto& [key, value] : json["seconds"].items()) {
        names.push_back(key);
        EXPECT_TRUE(value.is_number()) << key;
    }
    EXPECT_EQ(names, (std::vector<std::string>{"compile", "gradient", "guide", "load", "optimizer", "primal", "total"}));
    EXPECT_EQ(json["kernels"]["trace_closest"]["calls"], 3);
    EXPECT_EQ(json["kernels"]["trace_closest"]["seconds"], 0.5);
    EXPECT_EQ(json["memory"]["budget_bytes"], 512u << 20);
    EXPECT_EQ(json["memory"]["device_peak_bytes"], 0);
    EXPECT_GT(json["memory"]["host_peak_bytes"].get<std::uint64_t>(), 1u << 20); // this process surely has a mebibyte
    EXPECT_EQ(json["memory"]["refused_splits"], 3);
    EXPECT_EQ(json["paths"], 14);
    EXPECT_EQ(json["dropped"]["film.nonfinite"], 2);
    EXPECT_EQ(json["loss"][0], 0.5);
    EXPECT_TRUE(json["loss"][1].is_null());
    EXPECT_EQ(json["outputs"]["gradient"], "a.exr");
}

TEST(Report, HasNoSecondsOfKernelsThatWereNotTimed) {
    Report report(Options{});
    report.kernels["trace_closest"] = {.calls = 3};
    EXPECT_EQ(report.toJson()["kernels"]["trace_closest"].dump(), R"({"calls":3})");
}

TEST(Report, EmptyPartsKeepTheirKind) {
    const nlohmann::ordered_json json = Report(Options{}).toJson();
    EXPECT_EQ(json["kernels"].dump(), "{}");
    EXPECT_EQ(json["dropped"].dump(), "{}");
    EXPECT_EQ(json["outputs"].dump(), "{}");
    EXPECT_EQ(json["loss"].dump(), "[]");
}

TEST(Report, HostPeakGrowsWithMemory) {
    const std::vector<char> block(std::size_t(256) << 20, 1); // more than anything else here
    EXPECT_GE(hostPeakBytes(), block[12345] ? block.size() : 0);
    EXPECT_LT(hostPeakBytes(), 64 * block.size()); // bytes, not KiB; the peak is the whole process's, and a sanitizer's own counts
}

} // namespace
} // namespace cmpg
