// When a run keeps a checkpoint, and where it goes on from one.
#include "app/checkpoints.h"

#include "app/run_identity.h"
#include "base/error.h"

#include <nlohmann/json.hpp>

namespace cmpg {

Checkpoints::Checkpoints(const Options& options, Checkpoint::Identity identity, std::string madeWith, EventLog& log)
    : folder_(options.output), resumed_(options.resume), interval_(checkpointInterval(options)), steps_(options.recovery.steps),
      stopAfter_(options.stopAfter.value_or(options.recovery.steps)), identity_(std::move(identity)), config_(toConfig(options).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)),
      madeWith_(std::move(madeWith)), log_(log) {}

std::optional<Checkpoint> Checkpoints::find() const {
    if (resumed_.empty())
        return std::nullopt;
    const std::string folder = resumed_.string();
    std::vector<std::string> refused;
    std::optional<Checkpoint> found = findCheckpoint(resumed_, refused);
    if (!found && !refused.empty())
        throw Error(ErrorKind::Input, "no checkpoint in '" + folder + "' can be used: " + refused.front(), "",
                    "begin anew without --resume");
    for (const std::string& reason : refused)
        log_.warn("checkpoint_refused", "a checkpoint is left aside for an older one: " + reason);
    if (!found) {
        log_.warn("resume", "'" + folder + "' has no checkpoint: the run begins at step 0");
        return found;
    }
    requireSameRun(*found, identity_, folder);
    for (const auto& [option, steps] : {std::pair("--steps", steps_), std::pair("--stop-after", stopAfter_)})
        if (found->state.step > steps)
            throw Error(ErrorKind::Usage,
                        "the run in '" + folder + "' is at step " + std::to_string(found->state.step) + ", beyond " + option + " " + std::to_string(steps));
    if (found->madeWith != madeWith_)
        log_.warn("other_device", "the run was on " + found->madeWith + " and goes on on " + madeWith_ + ": rounding may differ from here on");
    log_.setStep(found->state.step);
    log_.info("resume", std::string("goes on at step ") + std::to_string(found->state.step));
    return found;
}

void Checkpoints::afterStep(const Optimization& run, const ImageModel& model) {
    const bool due = (interval_.steps > 0 && run.state().step - tried_ >= interval_.steps) || (interval_.seconds > 0 && since_.seconds() >= interval_.seconds);
    if (due)
        write(run, model);
}

void Checkpoints::write(const Optimization& run, const ImageModel& model) {
    tried_ = run.state().step;
    since_ = {};
    if (!on() || tried_ == written_) // before its first step a run has nothing to lose
        return;
    try {
        const std::vector<FileSection> sections = checkpointSections(run, model, identity_, config_, madeWith_);
        double bytes = 0;
        for (const FileSection& s : sections)
            bytes += double(s.bytes.size());
        writeCheckpointFile(folder_, sections);
        written_ = tried_;
        log_.info("checkpoint", "checkpoint written", {{"bytes", bytes}, {"seconds", since_.seconds()}});
    } catch (const Error& error) {
        log_.warn("write_failed", std::string(error.what()) + ". The run goes on in memory, without a checkpoint of this step");
    }
    since_ = {};
}

} // namespace cmpg
