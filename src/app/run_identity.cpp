// What an optimisation is, by name: its options stand under their names on the command line.
#include "app/run_identity.h"

#include "base/error.h"
#include "optimize/content_identity.h"
#include "scene/file_io.h"

#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

// What bears on the result, but is told by contents instead, and what does not. The number of steps bears on it through the schedule alone:
// a run may go on beyond what was first asked for.
bool isIdentity(const std::string& key, const Options& options) {
    for (const char* other : {"command", "input", "param", "target", "mask", "target-exposure", "set", "load-guide", "camera", "width", "height",
                              "device", "memory", "train", "checkpoint-every", "quality", "time-budget", "stop-after",
                              "environment", "environment-rotation", "define"})
        if (key == other)
            return false;
    return key != "steps" || options.schedule != Schedule::Constant;
}

} // namespace

Checkpoint::Identity runIdentity(const Options& options, const Scene& scene, const std::vector<std::uint32_t>& parameters,
                                 const std::vector<View>& views, const std::vector<Target>& targets) {
    Checkpoint::Identity identity;
    const nlohmann::ordered_json config = toConfig(options);
    for (const auto& [key, value] : config.items())
        if (isIdentity(key, options))
            identity.emplace_back("--" + key, value.dump());
    std::string names;
    for (const std::uint32_t p : parameters)
        names += (names.empty() ? "" : ", ") + scene.parameters[p].name;
    identity.emplace_back("--param", names);
    for (auto& entry : contentIdentity(scene, parameters, views, targets))
        identity.push_back(std::move(entry));
    if (!options.loadGuide.empty())
        identity.emplace_back("the guide of --load-guide", digestOf(readFile(options.loadGuide)));
    return identity;
}

void requireSameRun(const Checkpoint& checkpoint, const Checkpoint::Identity& run, const std::string& folder) {
    const auto valueOf = [](const Checkpoint::Identity& identity, const std::string& name) -> const std::string* {
        for (const auto& [key, value] : identity)
            if (key == name)
                return &value;
        return nullptr;
    };
    const auto refuse = [&](const std::string& name, const std::string* was, const std::string* is) {
        const bool option = name.starts_with("--");
        const std::string none = "none", values = option ? ": it has " + (was ? *was : none) + ", this one " + (is ? *is : none) : "";
        throw Error(option ? ErrorKind::Usage : ErrorKind::Input, "the run in '" + folder + "' is another one: " + name + " differs" + values,
                    "its result would be neither this run's nor that one's",
                    option ? "leave " + name + " away, or begin anew without --resume" : "give what the run was made with, or begin anew without --resume");
    };
    for (const auto& [name, value] : checkpoint.identity)
        if (const std::string* is = valueOf(run, name); !is || *is != value)
            refuse(name, &value, is);
    for (const auto& [name, value] : run)
        if (!valueOf(checkpoint.identity, name))
            refuse(name, nullptr, &value);
}

} // namespace cmpg
