// What a recovery is, by name: options stand under their names on the command line.
#include "library/recovery_identity.h"

#include "base/error.h"
#include "optimize/content_identity.h"
#include "scene/file_io.h"

#include <charconv>
#include <type_traits>

namespace cmpg::v1 {
namespace {

constexpr const char* kInterface = "2"; // of the entries: others cannot be compared with

template <class T> std::string textOf(T value) {
    if constexpr (std::is_same_v<T, bool>) {
        return value ? "on" : "off";
    } else {
        char text[40];
        return {text, std::to_chars(text, text + sizeof text, value).ptr}; // the shortest that is this number
    }
}

const std::string* valueOf(const Checkpoint::Identity& identity, const std::string& name) {
    for (const auto& [key, value] : identity)
        if (key == name)
            return &value;
    return nullptr;
}

[[noreturn]] void refuse(const std::string& name, const std::string* was, const std::string* is, const std::filesystem::path& folder) {
    const bool content = name.starts_with("the "); // and else an option
    const std::string none = "none", values = ": it has " + (was ? *was : none) + ", this one " + (is ? *is : none);
    std::vector<std::string> options;
    if (!content)
        options.push_back(name.substr(0, name.find(' '))); // "rate of roughness"
    options.emplace_back("resume");
    throw Error(content ? ErrorKind::Input : ErrorKind::Usage, "the run in '" + folder.string() + "' is another one: " + name + " differs" + (content ? "" : values),
                "its result would be neither this run's nor that one's", "give what it was made with, or begin anew", options);
}

} // namespace

Checkpoint::Identity identityOf(const RecoveryOptions& o, const OptimizeConfig& config, std::uint32_t maxDepth, const std::string& parameters) {
    const PathOptions& paths = o.paths;
    Checkpoint::Identity identity{{"interface", kInterface}};
    const auto add = [&](const std::string& name, const std::string& value) { identity.emplace_back(name, value); };
    add("param", parameters);
    add("spp", textOf(o.spp));
    add("spp-gradient", textOf(o.sppGradient));
    add("spp-difference", textOf(o.sppDifference));
    add("seed", textOf(o.seed));
    add("sampler", nameOf(paths.sampler, kSamplers));
    add("sampling", nameOf(paths.sampling, kSamplings));
    add("no-nee", textOf(!paths.lightSampling));
    add("pixel-sampling", nameOf(paths.pixelSampling, kPixelSamplings));
    add("positivize", textOf(paths.positivize));
    add("roulette", textOf(paths.roulette));
    add("save-guide", textOf(paths.guide.keep)); // which is learned from the first step on then
    add("guide-memory", textOf(paths.guideMemory));
    add("guide-share", textOf(paths.guide.share));
    add("cell-records", textOf(paths.guide.cellRecords));
    add("direction-share", textOf(paths.guide.directionShare));
    add("forgetting", textOf(paths.guide.forgetting));
    add("roulette-effort", textOf(paths.guide.rouletteEffort));
    add("max-depth", textOf(maxDepth));
    add("error-target", textOf(float(o.errorTarget))); // as exact as the option of the command line
    if (o.errorTarget > 0)
        add("batches", textOf(o.batches));
    add("loss", nameOf(o.loss, kLosses));
    add("optimizer", nameOf(o.optimizer, kOptimizers));
    for (std::size_t kind = 0; kind < kSlotKinds; ++kind) {
        const bool lobe = kind >= kCommonSlots && kind < kMaterialSlots; // runs without a rate for it are as they were before there was such a slot
        if (!lobe || config.optimizer.rates[kind] >= 0)
            add(std::string("rate of ") + slotName(SlotKind(kind)), textOf(config.optimizer.rates[kind]));
    }
    add("schedule", nameOf(o.schedule, kSchedules));
    if (o.schedule != Schedule::Constant) { // else steps may be added
        add("steps", textOf(o.steps));
        add("final-rate", textOf(o.finalRate));
    }
    add("total-variation", textOf(o.totalVariation));
    add("prior", textOf(o.prior));
    add("views-per-step", textOf(o.viewsPerStep));
    add("warm-up", textOf(o.warmUp));
    add("freeze", textOf(o.freeze));
    if (!paths.guide.load.empty())
        add("the guide that was loaded", digestOf(readFile(paths.guide.load)));
    return identity;
}

void requireSame(const Checkpoint::Identity& saved, const Checkpoint::Identity& own, const std::filesystem::path& folder) {
    if (const std::string* version = valueOf(saved, "interface"); !version || *version != kInterface)
        throw Error(ErrorKind::Input, "the checkpoint in '" + folder.string() + "' is of another version of the program", {}, "begin anew", {"resume"});
    for (const auto& [name, value] : saved)
        if (const std::string* is = valueOf(own, name); !is || *is != value)
            refuse(name, &value, is, folder);
    for (const auto& [name, value] : own)
        if (!valueOf(saved, name))
            refuse(name, nullptr, &value, folder);
}

} // namespace cmpg::v1
