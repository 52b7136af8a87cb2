// What stands behind a recovery of the library's surface: an optimisation over a renderer of its own, or over somebody's.
#pragma once

#include "library/renderer_state.h"
#include "optimize/batched_model.h"
#include "optimize/checkpoint.h"
#include "optimize/gradient_watch.h"
#include "optimize/recovery_run.h"

#include <cmpg/recovery.h>

#include <deque>
#include <list>
#include <mutex>
#include <optional>

namespace cmpg::v1 {

struct RecoveryProgress::State {
    std::uint32_t steps = 0;
    Checkpoint::Identity objective; // what the curvature is of
    struct Known {
        std::string parameter;
        std::pair<std::uint32_t, std::uint32_t> size; // width and height
        OptimizerKind method; // whose moments they are
        Moments moments;
    };
    std::vector<Known> known;
};

struct Recovery::State {
    std::shared_ptr<Renderer::State> base;
    const bool shared; // the renderer is somebody's, who has other passes made between the steps
    std::uint32_t steps;
    bool learns;
    std::uint32_t freeze; // step from which on the guide stays as it is
    Checkpoint::Identity identity;
    Checkpoint::Identity objective() const; // its entries on loss, cameras and targets
    GradientWatch watch;
    std::function<void(std::size_t, const Image&)> showImage;
    std::list<cmpg::Camera> moved; // cameras of targets
    std::vector<View> views;
    std::optional<RecoveryRun> run;
    std::uint64_t generation = 0; // of the renderer that the run is made of
    bool prepared = false;
    std::vector<std::vector<float>> initial; // values of the parameters
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes; // and their widths and heights
    BatchedModel* batched = nullptr; // where gradients have an error target
    std::deque<double> paces; // of the last steps: seconds for the work of one view
    double kindSeconds = 0;   // the most that compiling for one kind of passes took in a step

    // A recovery with a renderer of its own.
    State(std::shared_ptr<Device::State> device, Scene::State& source, const std::vector<Target>& targets, const RecoveryOptions& options);
    State(std::shared_ptr<Renderer::State> renderer, const std::vector<Target>& targets, RecoveryOptions options, const RecoveryProgress& from);
    ~State();
    State(const State&) = delete;

    cmpg::Scene& scene() const { return base->scene; }
    const std::vector<std::uint32_t>& parameters() const { return base->parameters; }
    pid_t process() const { return base->process(); }
    Communicator& ranks() const { return base->device->ranks(); }
    std::recursive_mutex& mutex() const { return base->device->mutex; }
    Optimization& optimization() { return run->optimization(); }

    // The median of the last five paces, with this one: a step that tried another method says little of the next.
    double usualPace(double pace);
    std::size_t indexOf(const std::string& name) const;
    void requireTarget(std::size_t target) const;
    void requirePicture(std::size_t target, std::uint32_t spp) const; // the same, told to the other ranks
    bool ended() const { return generation != base->generation; }
    // requireGoing(); of several ranks, before all else that they do together, Error(Usage) if they stand elsewhere or are not asked for the same: `what`.
    void requireSameOnAll(const std::string& what) const;
    void requireGoing() const; // Error(Usage) where it has ended; in Work, which has taken over what others changed
    // `ahead`: kernels are made while others run already, which nothing can interrupt.
    void prepare(bool ahead);
    // Between steps nothing is learned from what others have a renderer make.
    template <class Work> void learning(Work&& work) {
        if (!shared)
            return work();
        const bool learnsNow = learns && optimization().state().step < freeze;
        base->passes->setLearning(learnsNow);
        try {
            work();
        } catch (...) {
            base->passes->setLearning(false);
            throw;
        }
        base->passes->setLearning(false);
        base->fresh &= !learnsNow;
    }
    void setParameters(const std::vector<std::vector<float>>& values);
    std::vector<std::vector<float>> current() const;
    std::string madeWith() const { return base->device->info.name + ", " + base->device->info.driver; }

  private:
    void begin(const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from);
    RecoveryRun::Steps planOf(const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from);
    void goOn(RecoveryRun::Steps& plan, const RecoveryProgress::State& before) const;
    std::string names() const;
};

} // namespace cmpg::v1
