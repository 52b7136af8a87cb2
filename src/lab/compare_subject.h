// What a comparison differentiates, and a renderer for each of its methods.
#pragma once

#include "lab/compare_methods.h"
#include "lab/compare_runner.h"
#include "session/session.h"

#include <cmpg/recovery.h>
#include <cmpg/renderer.h>

namespace cmpg {

enum class CompareMode { Forward, Reverse, Optimize };
const char* compareModeName(CompareMode mode);
std::vector<CompareMode> parseModes(const std::string& list); // comma-separated, each once; Error(Usage)

// Scene, view and inputs of a comparison, read and checked without a device.
struct CompareSubject {
    CompareSubject(const Options& options, Report& report);
    CompareSubject(const CompareSubject&) = delete; // one device, one report
    CompareSubject& operator=(const CompareSubject&) = delete;

    const Options& options;
    std::vector<CompareMode> modes;
    std::vector<CompareMethod> methods;
    Session session;                       // the scene with --set applied, and the parameters
    std::vector<std::vector<float>> truth; // their values before --set: what an optimisation is to find
    SeenView view;
    std::vector<v1::Direction> directions; // forward
    Image adjoint;                         // reverse: given, or made by beginComparison()
    bool steps = false;                    // reverse: passes make an image and its adjoint themselves, as steps of a recovery do
    std::uint32_t part = 0;                // of a measurement: each has random numbers of its own
    std::vector<v1::Target> targets;       // one per --target; several of `optimize` alone
    Image picture;                         // of the scene as it is set, for the report

    bool has(CompareMode mode) const;
    std::size_t parameterEntries() const;
    std::string parameterNames() const; // in a row
    v1::PathOptions paths(const CompareMethod& method) const;
    v1::PassOptions pass(std::uint32_t spp, std::uint64_t seed) const; // of the view
    // Of an image against the target.
    Image adjointOf(const Image& image) const;
    // Of all random numbers but an optimisation's: none that another command has used with this --seed. An adjoint made by `gradient`
    // holds noise of its random numbers, and a pass with the same ones would see that noise as signal.
    std::uint64_t seed() const { return (options.seed ^ 0x636f6d7061726521ull) + 0xd1342543de82ef95ull * part; }
};

// Opens the report in the folder of the options, then renders the picture, and the adjoint where a target's loss has to give it.
void beginComparison(CompareSubject& subject, Report& report);

// One method's renderer, trained.
class MethodRenderer {
  public:
    MethodRenderer(CompareSubject& subject, const CompareMethod& method);

    // Learning passes, then a pass thrown away, after which nothing is left to be compiled. `turn`: others learn from other numbers.
    void train(CompareMode mode, std::uint32_t turn = 0);
    Pass pass(CompareMode mode, std::uint32_t index); // forward: the image; reverse: the gradients of all parameters in a row

    double trainSeconds() const { return trainSeconds_; }
    const v1::PassReport& last() const { return last_; } // of the last pass, with how it drew directions

  private:
    // `learn`: passes before it, and before the image of a step.
    Pass passAfter(CompareMode mode, std::uint64_t seed, std::uint32_t learn);

    CompareSubject& subject_;
    CompareMethod method_;
    v1::Renderer renderer_;
    v1::PassReport last_;
    double trainSeconds_ = 0;
};

// "primal, roulette", or empty where the method leaves nothing to choose. `report`: of a pass, or of a recovery.
std::string describeDecision(const CompareMethod& method, const v1::PassReport& report);

} // namespace cmpg
