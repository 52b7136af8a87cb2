// When a run keeps a checkpoint, and where it continues from one.
#include "app/checkpoints.h"

#include "base/error.h"
#include "session/explain.h"

#include <nlohmann/json.hpp>

namespace cmpg {

Checkpoints::Checkpoints(const Options& options, EventLog& log)
    : folder_(options.output), resumed_(options.resume), interval_(checkpointInterval(options)), steps_(options.recovery.steps),
      stopAfter_(options.stopAfter.value_or(options.recovery.steps)),
      config_(toConfig(options).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)), log_(log) {}

void Checkpoints::resume(v1::Recovery& run) {
    if (resumed_.empty()) {
        const std::filesystem::path aside = ranks().isRoot() ? v1::Recovery::setAside(folder_) : std::filesystem::path();
        if (!aside.empty())
            log_.warn("checkpoint_replaced", "'" + folder_.string() + "' has the checkpoint of another run, which is now " + aside.filename().string() + ": --resume continues this run");
        return;
    }
    const std::string folder = resumed_.string();
    std::vector<v1::Warning> warnings;
    const bool found = run.resume(resumed_, &warnings);
    for (const v1::Warning& warning : warnings)
        log_.warn(warning.event, withOptions(warning.text, warning.options), warning.numbers);
    if (!found) {
        log_.warn("resume", "'" + folder + "' has no checkpoint: the run begins at step 0");
        return;
    }
    if (run.steps() == stopAfter_ && stopAfter_ < steps_)
        log_.warn("resume", "the run in '" + folder + "' has done the " + std::to_string(stopAfter_) + " steps of --stop-after: give --stop-after " + std::to_string(steps_) + " to continue to the last");
    for (const auto& [option, steps] : {std::pair("--steps", steps_), std::pair("--stop-after", stopAfter_)})
        if (run.steps() > steps)
            throw Error(ErrorKind::Usage,
                        "the run in '" + folder + "' is at step " + std::to_string(run.steps()) + ", beyond " + option + " " + std::to_string(steps));
    log_.setStep(run.steps());
    log_.info("resume", "continues at step " + std::to_string(run.steps()));
}

void Checkpoints::afterStep(const v1::Recovery& run) {
    const bool due = (interval_.steps > 0 && run.steps() - tried_ >= interval_.steps) || (interval_.seconds > 0 && since_.seconds() >= interval_.seconds);
    if (due)
        write(run);
}

void Checkpoints::write(const v1::Recovery& run) {
    tried_ = run.steps();
    since_ = {};
    if (!on() || tried_ == written_) // before its first step a run has nothing to lose
        return;
    try {
        const std::uint64_t bytes = run.save(folder_, config_);
        written_ = tried_;
        log_.info("checkpoint", "checkpoint written", {{"bytes", double(bytes)}, {"seconds", since_.seconds()}});
    } catch (const Error& error) {
        log_.warn("write_failed", std::string(error.what()) + ". The run continues in memory, without a checkpoint of this step");
    }
    since_ = {};
}

} // namespace cmpg
