// Everything a user can ask of the program: one struct, filled by the command line and by --config. option_table.h says what each option is.
#pragma once

#include <cmpg/recovery.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace cmpg {

enum class Command { None, Open, Render, Gradient, Optimize, Compare, Tradeoff, Inspect, View, Guide, ListDevices, Version };
const char* commandName(Command command);

// What the defaults aim at; docs/tradeoffs.md has the measurements.
enum class Quality { Preview, Balanced, Accurate };

struct Options {
    Command command = Command::None;
    std::string input;  // the scene, the image of `view`, the file of `guide`
    std::string output; // -o
    std::string config; // --config
    bool headless = false, json = false, quiet = false;
    std::string displayServer; // --display-server: HOST:PORT; empty: none

    // Common to all commands. Unset optionals depend on the command and the quality: see effectiveSpp() and the like.
    Quality quality = Quality::Balanced;
    std::optional<std::uint32_t> spp, sppGradient;
    std::optional<std::uint32_t> width, height, maxDepth;
    std::string camera; // empty: the first
    std::uint64_t seed = 0;
    std::string device;           // empty: the best
    std::uint64_t memory = 1024;  // MiB
    bool allFeatures = false;     // same results
    bool kernelTimes = false;
    std::vector<std::string> texture; // "P=WxH"
    std::vector<std::string> set;     // "P=VALUE" or "P=FILE"
    std::string environment;      // a picture in place of the scene's own surroundings
    std::optional<float> environmentRotation; // degrees about +y
    std::vector<std::string> define;          // "NAME=VALUE", variables of the scene
    std::string filter;                       // as ReconstructionFilter::parse() reads it; empty: the scene's own
    Sampler sampler = Sampler::Sobol;
    Sampling sampling = Sampling::Auto;
    bool noLightSampling = false;
    bool roulette = true; // by the adjoint, where it pays
    bool positivize = false;
    std::optional<std::uint32_t> train, trainSpp; // learning passes before the measured one, and their samples per pixel
    std::string saveGuide, loadGuide;
    std::uint64_t guideMemory = 64; // MiB
    float guideShare = v1::GuideOptions{}.share, rouletteEffort = v1::GuideOptions{}.rouletteEffort;
    std::uint32_t cellRecords = v1::GuideOptions{}.cellRecords;
    double directionShare = v1::GuideOptions{}.directionShare, forgetting = v1::GuideOptions{}.forgetting;
    std::optional<PixelSampling> pixelSampling; // default: adjoint

    // render, gradient and optimize: sample until that error or time is reached
    std::optional<float> errorTarget; // |standard error| / |estimate|
    std::optional<float> timeBudget;  // seconds since the program began

    // render and gradient
    std::string layers;
    std::optional<std::uint32_t> batches; // with random numbers of their own, whose spread tells the error

    // open, gradient and optimize
    std::vector<std::string> param;
    std::vector<std::string> target; // FILE or CAMERA=FILE
    Loss loss = Loss::Mse;
    std::vector<std::string> mask;   // FILE or CAMERA=FILE
    float targetExposure = 0;

    // gradient
    std::string direction = "one"; // or "self", or a file
    std::string adjoint;
    bool check = false;

    // optimize; samples, seed, loss and paths are those of above
    v1::RecoveryOptions recovery;
    std::vector<std::string> rate;         // "RATE" or "SLOT=RATE"
    std::optional<std::uint32_t> freeze;   // step from which on it stays as it is
    std::optional<std::uint32_t> stopAfter; // steps of --steps that are done
    std::optional<std::uint32_t> sppPictures; // of images made after the last step
    std::string checkpointEvery = "10m"; // steps, or a time with its unit
    std::string resume;                  // the folder of the run to go on with; empty: a new one

    // compare
    std::string methods = "plain,primal,conditional,ours";
    std::string mode = "reverse"; // comma-separated
    std::optional<float> time;    // seconds for each method
    std::optional<std::uint32_t> seeds;
    std::string reference = "auto"; // or a file or folder
    std::optional<float> referenceTime;
    std::uint32_t adjointSpp = 256;

    // view
    bool isSigned = false;
    float exposure = 0;
    std::optional<float> scale;
    std::string layer;

    // guide
    bool validateGuide = false, csv = false;
    std::optional<std::uint32_t> cell; // default: the one with most records
    std::string weights = "1,1";      // of light and of derivatives in the mixture drawn

    std::uint32_t effectiveSpp() const;         // of images
    std::uint32_t effectiveSppGradient() const; // of derivative passes
    std::uint32_t effectiveTrain() const;
    std::uint32_t effectiveTrainSpp() const;
    std::uint32_t effectiveDepth(std::uint32_t scenes) const; // of a scene that asks for `scenes` segments
    std::uint32_t effectiveBatches() const; // 0: samples are not divided
    bool hasBudget() const { return errorTarget || timeBudget; }
    bool isReverse() const { return command == Command::Optimize || !adjoint.empty() || !target.empty(); }
};

// What reproduces a run: the command, its input and all options that bear on the result, defaults included; no output paths. File
// names are made absolute, so that it can be used from any folder.
nlohmann::ordered_json toConfig(const Options& options);
// Takes over what a run.json says. Throws Error(Usage) on unknown keys and values of the wrong kind.
void applyConfig(const nlohmann::json& config, Options& options);
// Keys of run.json that bear on the result by themselves: two runs that are the same agree in them.
std::set<std::string> identityKeys();
// Throws Error(Usage) on values and combinations that make no sense.
void validate(const Options& options);

// Names of the values of an option's enumeration; cmpg/options.h has others.
inline constexpr EnumName<Quality> kQualities[] = {
    {Quality::Preview, "preview"}, {Quality::Balanced, "balanced"}, {Quality::Accurate, "accurate"}};
inline constexpr EnumName<bool> kRoulettes[] = {{false, "off"}, {true, "adjoint"}};
inline constexpr EnumName<Command> kCommands[] = {
    {Command::Open, "open"},
    {Command::Render, "render"},   {Command::Gradient, "gradient"}, {Command::Optimize, "optimize"},
    {Command::Compare, "compare"}, {Command::Tradeoff, "tradeoff"}, {Command::Inspect, "inspect"},   {Command::View, "view"},
    {Command::Guide, "guide"},     {Command::ListDevices, "list-devices"}, {Command::Version, "version"}};

} // namespace cmpg
