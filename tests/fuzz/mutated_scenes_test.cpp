// Scenes as strangers may make them: what loads is rendered and differentiated, and no number that is none comes out. With CMPG_VALIDATION=gpu
// also no kernel reads or writes out of range, which would end a pass with an error.
#include "support/render_fixture.h"
#include "support/scene_mutation.h"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <numeric>
#include <unistd.h>

namespace cmpg {
namespace {

namespace fs = std::filesystem;
using test::device;

constexpr LoadOptions kLimits = {.maxTextureSize = 64, .maxTriangles = 1 << 12, .maxTextureBytes = 1 << 20};

std::string readText(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class MutatedScenes : public testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(folder_);
        device().keepKernels(); // all scenes use the same ones
    }
    void TearDown() override {
        fs::remove_all(folder_);
        std::cout << loaded_ << " scenes loaded, " << refused_ << " refused; contributions dropped and counted: " << dropped_ << "\n";
    }

    // Changes of the fuzzer's seeds, as many of each; the first is none.
    void run(std::uint32_t changes) {
        std::vector<fs::path> seeds;
        for (const auto& entry : fs::directory_iterator(CMPG_SOURCE_DIR "/tests/fuzz/corpus/scene"))
            if (entry.path().extension() == ".gltf")
                seeds.push_back(entry.path());
        ASSERT_FALSE(seeds.empty());
        std::sort(seeds.begin(), seeds.end());
        for (const fs::path& seed : seeds) {
            const nlohmann::json whole = nlohmann::json::parse(readText(seed));
            for (std::uint32_t change = 0; change < changes; ++change) {
                nlohmann::json json = whole;
                test::SceneMutation mutation(change);
                for (std::uint32_t i = 0; i < std::min(change, 1 + change % 4); ++i)
                    mutation.apply(json);
                SCOPED_TRACE(seed.filename().string() + ", change " + std::to_string(change));
                tryScene(json);
                if (HasFailure())
                    return; // the first tells
            }
        }
    }

    std::uint32_t loaded_ = 0, refused_ = 0;
    std::uint64_t dropped_ = 0;

  private:
    void tryScene(const nlohmann::json& json) {
        const fs::path file = folder_ / "scene.gltf";
        std::ofstream(file) << json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        try {
            Scene scene = loadGltf(file, kLimits);
            ++loaded_;
            use(scene);
        } catch (const Error& error) {
            refused_ += error.code == ExitCode::Input;
            EXPECT_EQ(error.code, ExitCode::Input) << error.what() << "\n" << error.cause;
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
        config.differentiable.resize(scene.parameters.size());
        std::iota(config.differentiable.begin(), config.differentiable.end(), 0u);
        std::vector<std::vector<float>> ones;
        for (const Parameter& p : scene.parameters)
            ones.emplace_back(p.entries(), 1.0f);
        Renderer renderer(device(), scene, config);
        constexpr int kWidth = 16, kHeight = 12;
        const Image adjoint(kWidth, kHeight, 3, 1.0f);
        std::vector<std::vector<double>> gradients;
        for (std::size_t camera = 0; camera < std::min<std::size_t>(scene.cameras.size(), 2); ++camera) {
            const View view{&scene.cameras[camera], kWidth, kHeight};
            renderer.setSampling({});
            expectFinite(renderer.render(view, 1, {1, 0, 0}).values, "image");
            expectFinite(renderer.forward(view, 1, {1, 0, 1}, config.differentiable, ones).values, "derivative");
            renderer.setSampling({.record = true, .measure = true});
            renderer.reverse(view, 2, {1, 0, 3}, adjoint, {}, {}, gradients);
            renderer.updateGuide();
            const double reference = renderer.lastPass().reference;
            renderer.setSampling({.kind = Sampling::Conditional, .record = true, .roulette = true, .reference = reference});
            renderer.reverse(view, 2, {1, 1, 1}, adjoint, {}, {}, gradients);
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

    const fs::path folder_ = fs::temp_directory_path() / ("cmpg-mutated-" + std::to_string(::getpid()));
};

TEST_F(MutatedScenes, StayWithinNumbersAndBounds) {
    run(25);
    EXPECT_GE(loaded_, 30u); // else the changes only break files
    EXPECT_GE(refused_, 5u); // else they hardly change them
}

TEST_F(MutatedScenes, FullStayWithinNumbersAndBounds) { run(1000); }

} // namespace
} // namespace cmpg
