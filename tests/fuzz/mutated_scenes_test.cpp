// Scenes as strangers may make them: what loads is rendered and differentiated, and no number that is none comes out. With CMPG_VALIDATION=gpu
// also no kernel reads or writes out of range, which would end a pass with an error.
#include "base/error.h"
#include "scene_folder.h"
#include "support/render_fixture.h"
#include "support/scene_mutation.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>

namespace cmpg {
namespace {

namespace fs = std::filesystem;
using test::device;

const LoadOptions kLimits = {.maxTextureSize = 64, .maxTriangles = 1 << 12, .maxTextureBytes = 1 << 20};

std::string readText(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// Kernels whose every access is looked at take minutes to compile: those of derivative images are left out.
const bool kLooked = std::getenv("CMPG_VALIDATION") && std::string(std::getenv("CMPG_VALIDATION")) == "gpu";

// The tree after records everywhere, so that the first pass is a guided one.
SdTree learned(SdTree tree) {
    std::vector<CellRecords> records;
    for (std::uint32_t cell = 0; cell < tree.cells().size(); ++cell) {
        std::array<GuideMass, 4> leaf;
        leaf.fill({1, 0.5, 0.25});
        records.push_back({cell, 30, 40, 30, std::vector(tree.cells()[cell].nodes.size(), leaf)});
    }
    tree.update(records);
    return tree;
}

class MutatedScenes : public testing::Test {
  protected:
    void SetUp() override {
        device().keepKernels(); // all scenes use the same ones
    }
    void TearDown() override {
        std::cout << loaded_ << " scenes loaded, " << refused_ << " refused; contributions dropped and counted: " << dropped_ << "\n";
    }

    // The fuzzer's seeds, and changes of those in glTF's JSON, as many of each.
    void run(std::uint32_t changes, bool forward) {
        forward_ = forward;
        for (const fs::path& seed : seeds({".gltf", ".glb"})) {
            SCOPED_TRACE(seed.filename().string());
            tryScene(readText(seed));
            EXPECT_EQ(refused_, 0u);
            if (HasFailure())
                return; // the first tells
        }
        loaded_ = 0;
        for (const fs::path& seed : seeds({".gltf"})) {
            const nlohmann::json whole = nlohmann::json::parse(readText(seed));
            for (std::uint32_t change = 1; change < changes; ++change) {
                nlohmann::json json = whole;
                test::SceneMutation mutation(change);
                for (std::uint32_t i = 0; i <= change % 2; ++i)
                    mutation.apply(json);
                SCOPED_TRACE(seed.filename().string() + ", change " + std::to_string(change));
                tryScene(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
                if (HasFailure())
                    return;
            }
        }
        EXPECT_GE(loaded_, 2 * changes / 3); // else the changes only break files
        EXPECT_GE(refused_, changes / 6);    // else they hardly change them
    }

    std::uint32_t loaded_ = 0, refused_ = 0;
    std::uint64_t dropped_ = 0;
    bool forward_ = true;

  private:
    static std::vector<fs::path> seeds(const std::set<fs::path>& extensions) {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(CMPG_SOURCE_DIR "/tests/fuzz/corpus/scene"))
            if (extensions.contains(entry.path().extension()))
                files.push_back(entry.path());
        EXPECT_GE(files.size(), extensions.size());
        std::sort(files.begin(), files.end());
        return files;
    }

    void tryScene(const std::string& text) {
        const fs::path file = folder_.holding({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        try {
            Scene scene = loadScene(file, kLimits);
            ++loaded_;
            use(scene);
        } catch (const Error& error) {
            refused_ += error.kind == ErrorKind::Input;
            EXPECT_EQ(error.kind, ErrorKind::Input) << error.what() << "\n" << error.cause;
        }
    }

    void use(Scene& scene) {
        RenderConfig config;
        config.allFeatures = true; // for the same kernels whatever the scene has
        config.guiding = config.learning = config.roulette = true;
        config.guide.cellRecords = 20;
        config.maxDepth = 4;
        config.memoryBudget = std::uint64_t(16) << 20;
        config.guideMemory = std::uint64_t(1) << 20;
        const std::string all = "*";
        config.differentiable = scene.selectDifferentiable({&all, 1});
        std::vector<std::vector<float>> ones;
        for (const std::uint32_t p : config.differentiable)
            ones.emplace_back(scene.parameters[p].entries(), 1.0f);
        Renderer renderer(device(), scene, config);
        renderer.setGuide(learned(renderer.guide()));
        constexpr int kWidth = 16, kHeight = 12;
        const Image adjoint(kWidth, kHeight, 3, 1.0f);
        std::vector<std::vector<double>> gradients;
        for (std::size_t camera = 0; camera < std::min<std::size_t>(scene.cameras.size(), 2); ++camera) {
            const View view{&scene.cameras[camera], kWidth, kHeight};
            expectFinite(renderer.render(view, 1, {1, 0, 0}).values, "image");
            if (forward_)
                expectFinite(renderer.forward(view, 1, {1, 0, 1}, config.differentiable, ones, {.method = {Sampling::Conditional}}).values, "derivative");
            const PassPlan plan{.method = {Sampling::Conditional, true}, .record = true, .reference = 1};
            for (std::uint32_t step = 0; step < 2; ++step) {
                renderer.reverse(view, 2, {1, step, 1}, adjoint, {}, {}, gradients, plan);
                renderer.updateGuide();
            }
        }
        for (const std::vector<double>& gradient : gradients)
            expectFinite(gradient, "gradient");
        for (const auto& [kind, count] : renderer.statistics().dropped)
            dropped_ += count;
    }

    template <class T> static void expectFinite(const std::vector<T>& values, const char* what) {
        const auto bad = std::count_if(values.begin(), values.end(), [](T v) { return !std::isfinite(v); });
        EXPECT_EQ(bad, 0) << what;
    }

    const fuzz::SceneFolder folder_{"scene.gltf"};
};

TEST_F(MutatedScenes, StayWithinNumbersAndBounds) { run(30, !kLooked); }

TEST_F(MutatedScenes, FullStayWithinNumbersAndBounds) { run(1000, true); }

} // namespace
} // namespace cmpg
