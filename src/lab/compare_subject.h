// What a comparison differentiates, and a renderer for each of its methods.
#pragma once

#include "lab/compare_methods.h"
#include "lab/compare_runner.h"
#include "optimize/target.h"
#include "render/guided_passes.h"
#include "session/options.h"
#include "session/report.h"

namespace cmpg {

enum class CompareMode { Forward, Reverse, Optimize };
const char* compareModeName(CompareMode mode);
std::vector<CompareMode> parseModes(const std::string& list); // comma-separated, each once; Error(Usage)

// Scene, view and inputs of a comparison, read and checked without a device.
struct CompareSubject {
    explicit CompareSubject(const Options& options);
    CompareSubject(const CompareSubject&) = delete; // the view points into the scene
    CompareSubject& operator=(const CompareSubject&) = delete;

    const Options& options;
    std::vector<CompareMode> modes;
    std::vector<CompareMethod> methods;
    Scene scene;                           // --set applied
    std::vector<std::uint32_t> parameters; // into scene.parameters
    std::vector<std::vector<float>> truth; // their values before --set: what an optimisation is to find
    View view;
    std::vector<std::vector<float>> directions; // forward
    Image adjoint;                              // reverse: given, or made by beginComparison()
    bool steps = false;                         // reverse: passes make an image and its adjoint themselves, as steps of a recovery do
    Target target;                              // empty without --target
    std::vector<View> furtherViews;             // optimize: of the targets after the first
    std::vector<Target> furtherTargets;         // of each of them
    Image picture;                              // of the scene as it is set, for the report

    bool has(CompareMode mode) const;
    std::size_t parameterEntries() const;
    // Of all random numbers but an optimisation's: none that another command has used with this --seed. An adjoint made by `gradient`
    // holds noise of its random numbers, and a pass with the same ones would see that noise as signal.
    std::uint64_t seed() const { return options.seed ^ 0x636f6d7061726521ull; }
};

RenderConfig renderConfig(const CompareSubject& subject, const CompareMethod& method);

// Opens the report in the folder of the options, then renders the picture, and the adjoint where a target's loss has to give it.
void beginComparison(Device& device, CompareSubject& subject, Report& report);

// One method's renderer, trained.
class MethodRenderer {
  public:
    MethodRenderer(Device& device, CompareSubject& subject, const CompareMethod& method);

    // Learning passes, then a pass thrown away, after which nothing is left to be compiled. `turn`: others learn from other numbers.
    void train(CompareMode mode, std::uint32_t turn = 0);
    Pass pass(CompareMode mode, std::uint32_t index); // forward: the image; reverse: the gradients of all parameters in a row

    double trainSeconds() const { return trainSeconds_; }
    SamplingDecision decision() const { return passes_.decision(); }
    const RenderStatistics& statistics() const { return renderer_.statistics(); }

  private:
    CompareSubject& subject_;
    CompareMethod method_;
    Renderer renderer_;
    GuidedPasses passes_;
    double trainSeconds_ = 0;
};

// "primal, roulette", or empty where the method leaves nothing to choose.
std::string describeDecision(const CompareMethod& method, const SamplingDecision& decision);

} // namespace cmpg
