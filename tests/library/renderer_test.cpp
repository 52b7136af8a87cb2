// Renderers of the library make what the program makes.
#include "library_fixture.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

namespace cmpg::test {
namespace {

TEST(LibraryRenderer, FiltersAsTheProgramDoes) {
    const Folder folder;
    ASSERT_TRUE(program("render " + kBox + " --width 24 --spp 4 --filter tent:1.5 -o " + (folder / "tent.exr")));
    const auto render = [](const SceneOptions& options) { return Renderer(device(), Scene::load(kBox, options)).render({.width = 24, .spp = 4}).values; };
    const std::vector<float> tent = render({.filter = ReconstructionFilter{ReconstructionFilter::Kind::Tent, 1.5}});
    EXPECT_EQ(tent, loadImage(folder / "tent.exr").values);
    EXPECT_NE(tent, render({}));
    EXPECT_EQ(render({.filter = ReconstructionFilter{}}), render({})) << "glTF has a box";
    const Error error = errorOf([] { Scene::load(kBox, {.filter = ReconstructionFilter{ReconstructionFilter::Kind::Gaussian, 9}}); });
    EXPECT_EQ(error.kind, ErrorKind::Usage);
    EXPECT_EQ(error.options, std::vector<std::string>{"filter"});
}

TEST(LibraryRenderer, MakesTheImagesOfTheProgram) {
    const Folder folder;
    ASSERT_TRUE(program("render " + kBox + " --width 24 --spp 4 --seed 3 -o " + (folder / "plain.exr")));
    ASSERT_TRUE(program("render " + kBox + " --width 24 --spp 4 --train 2 --camera corner --set " + kPainting + "=0.5 -o " +
                        (folder / "guided.exr")));
    Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene);
    EXPECT_EQ(renderer.render({.width = 24, .spp = 4, .seed = 3}).values, loadImage(folder / "plain.exr").values);
    scene.set(kPainting, std::vector{0.5f}); // which the renderer was not told of
    EXPECT_EQ(renderer.render({.camera = "corner", .width = 24, .spp = 4, .train = 2}).values, loadImage(folder / "guided.exr").values);
}

TEST(LibraryRenderer, MakesTheDerivativesOfTheProgram) {
    const Folder folder;
    const std::string common = "gradient " + kBox + " --param " + kPainting + " --set " + kPainting + "=0.5 --spp-gradient 4 --train 2 ";
    const Image adjoint = Renderer(device(), Scene::load(kBox)).render({.width = 24, .spp = 4});
    saveImage(folder / "adjoint.exr", adjoint);
    ASSERT_TRUE(program(common + "--width 24 -o " + (folder / "forward.exr")));
    ASSERT_TRUE(program(common + "--adjoint " + (folder / "adjoint.exr") + " -o " + (folder / "backward.exr")));

    Renderer renderer(device(), greyScene(), {.paths = {}, .parameters = {"painting.*Color"}});
    ASSERT_EQ(renderer.parameters().size(), 1u);
    const std::vector<Direction> one{{kPainting, std::vector<float>(renderer.parameters()[0].entries(), 1.f)}};
    EXPECT_EQ(renderer.forward(one, {.width = 24, .spp = 4, .train = 2}).values, loadImage(folder / "forward.exr").values);
    const auto gradients = renderer.backward(adjoint, {.spp = 4, .train = 2});
    ASSERT_EQ(gradients.size(), 1u);
    EXPECT_EQ(std::vector<float>(gradients[0].begin(), gradients[0].end()), loadImage(folder / "backward.exr").values);
}

TEST(LibraryRenderer, FrozenDerivativesAreThoseOfTheImage) {
    Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, {.paths = {.maxDepth = 3}, .parameters = {"light.emission"}});
    const PassOptions pass{.width = 16, .spp = 4, .seed = 5, .frozen = true};
    const std::vector<float> emission = scene.values("light.emission");
    const Image derivative = renderer.forward(std::vector{Direction{"light.emission", emission}}, pass);
    const Image image = renderer.render(pass);
    scene.set("light.emission", std::vector{2 * emission[0], 2 * emission[1], 2 * emission[2]});
    const Image twice = renderer.render(pass);
    double largest = 0;
    for (std::size_t i = 0; i < image.values.size(); ++i) {
        ASSERT_NEAR(derivative.values[i], twice.values[i] - image.values[i], 1e-4 * (1 + std::abs(image.values[i])));
        largest = std::max(largest, double(image.values[i]));
    }
    EXPECT_GT(largest, 0);
    EXPECT_EQ(errorOf([&] { renderer.render({.train = 1, .frozen = true}); }).kind, ErrorKind::Usage);
}

TEST(LibraryRenderer, SaysWhereSumsOverflow) {
    Scene scene = Scene::load(CMPG_SOURCE_DIR "/scenes/furnace/scene.gltf");
    Renderer renderer(device(), scene);
    const PassOptions pass{.width = 16, .height = 16, .spp = 4};
    renderer.render(pass);
    scene.set("wall.emission", std::vector{3e38f});
    const Error error = errorOf([&] { renderer.render(pass); });
    EXPECT_EQ(error.kind, ErrorKind::Numerical);
    EXPECT_FALSE(error.remedy.empty());
}

TEST(LibraryRenderer, SamplesUntilTheErrorIsSmallEnough) {
    Renderer renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 4}, .parameters = {kPainting}});
    PassReport report;
    const Image image = renderer.render({.width = 32, .errorTarget = 0.03}, &report);
    EXPECT_EQ(report.end, BudgetEnd::Error);
    EXPECT_EQ(report.batches, kFewestBatches);
    EXPECT_LE(report.error.relative, 0.03);
    EXPECT_GT(report.error.relative, 0.01); // no stage more than it takes
    EXPECT_LT(report.error.low, report.error.high);
    EXPECT_EQ(report.paths, std::uint64_t(report.spp) * image.pixels());
    // The same samples in as many batches are the same image.
    PassReport again;
    EXPECT_EQ(renderer.render({.width = 32, .spp = report.spp, .batches = kFewestBatches}, &again).values, image.values);
    EXPECT_EQ(again.error.relative, report.error.relative);
    EXPECT_EQ(again.end, BudgetEnd::Samples);

    renderer.backward(Image(32, 24, 3, 1.f), {.spp = 16, .errorTarget = 1e-6}, &report);
    EXPECT_EQ(report.end, BudgetEnd::Samples);
    EXPECT_EQ(report.spp, 16u);
    renderer.render({.width = 32, .timeBudget = 0.3}, &report);
    EXPECT_EQ(report.end, BudgetEnd::Time);
    EXPECT_EQ(errorOf([&] { renderer.render({.spp = 12, .batches = 8}); }).options, std::vector<std::string>{"spp"});
    EXPECT_EQ(errorOf([&] { renderer.render({.batches = 8, .layers = true}); }).kind, ErrorKind::Usage);
}

TEST(LibraryRenderer, RefusesAnAdjointThatIsNotFinite) {
    Renderer renderer(device(), Scene::load(kBox), {.parameters = {kPainting}});
    Image adjoint(8, 8, 3, 1.f);
    adjoint.at(3, 3)[1] = NAN;
    const Error error = errorOf([&] { renderer.backward(adjoint, {.spp = 1}); });
    EXPECT_EQ(error.kind, ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("adjoint"), std::string::npos);
}

TEST(LibraryRenderer, GuidesAreSavedAndLoaded) {
    const Folder folder;
    const Scene scene = Scene::load(kBox);
    const Image adjoint(24, 18, 3, 1.f);
    RendererOptions options{.paths = {.maxDepth = 4, .sampling = Sampling::Conditional}, .parameters = {kPainting}};
    Renderer learner(device(), scene, options);
    EXPECT_EQ(errorOf([&] { learner.saveGuide(folder / "guide"); }).options, std::vector<std::string>{"train"});
    const auto learned = learner.backward(adjoint, {.spp = 8, .train = 2});
    learner.saveGuide(folder / "guide");
    options.paths.guide.load = folder / "guide";
    Renderer loaded(device(), scene, options);
    PassReport report;
    EXPECT_EQ(loaded.backward(adjoint, {.spp = 8}, &report), learned);
    EXPECT_TRUE(report.guided);
    EXPECT_EQ(report.sampling, Sampling::Conditional);
    EXPECT_NE(learner.backward(adjoint, {.spp = 8, .seed = 1}), learned);

    // The file says what it holds.
    const Guide guide = Guide::load(folder / "guide");
    const GuideFigures& figures = guide.figures();
    EXPECT_EQ(figures.updates, 2u);
    EXPECT_EQ(figures.parameters, std::vector<std::string>{kPainting});
    EXPECT_FALSE(figures.methods.empty());
    ASSERT_EQ(guide.cells().size(), figures.cells);
    EXPECT_EQ(guide.fault(), "");
    double records = 0;
    for (const GuideCellFigures& cell : guide.cells())
        records += cell.records;
    EXPECT_NEAR(records, figures.records, 1e-9 * records);
    const Image density = guide.density(figures.mostRecords, {1, 0, 0}, 16);
    double sum = 0;
    for (const float value : density.values)
        sum += double(value);
    EXPECT_NEAR(sum / double(density.values.size()), 1, 1e-5);
    EXPECT_EQ(errorOf([&] { guide.density(std::uint32_t(figures.cells), {1, 0, 0}, 16); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { guide.density(0, {1, 0, 0}, 17); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { Guide::load(folder / "nothing"); }).kind, ErrorKind::Input);

    // Learning goes on from what this renderer knows as it does from a file, or begins anew.
    const PassOptions further{.spp = 8, .seed = 2, .train = 1, .anew = false};
    const auto continued = learner.backward(adjoint, further);
    EXPECT_EQ(continued, loaded.backward(adjoint, further));
    const PassOptions again{.spp = 8, .seed = 2, .train = 1};
    RendererOptions without = options;
    without.paths.guide.load.clear();
    const auto fresh = Renderer(device(), scene, without).backward(adjoint, again);
    EXPECT_NE(fresh, continued);
    EXPECT_EQ(learner.backward(adjoint, again), fresh);

    options.parameters = {"light.emission"};
    const Error other = errorOf([&] { Renderer(device(), scene, options).backward(adjoint, {.spp = 8}); });
    EXPECT_EQ(other.kind, ErrorKind::Input);
    EXPECT_NE(other.cause.find(kPainting), std::string::npos) << other.cause;
    options.paths.guide.load = folder / "none";
    EXPECT_EQ(errorOf([&] { Renderer(device(), scene, options).backward(adjoint, {.spp = 8}); }).kind, ErrorKind::Input);
}

TEST(LibraryRenderer, ChecksItsDerivatives) {
    Renderer renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 2}, .parameters = {kPainting}});
    const Direction one{kPainting, std::vector<float>(64 * 64 * 3, 1.f)};
    const CheckResult result = renderer.check(one, {.width = 24, .spp = 4});
    EXPECT_TRUE(result.agrees());
    EXPECT_EQ(result.comparisons.front().what, "red mean");
    EXPECT_LT(std::abs(result.comparisons.front().relativeError()), 0.1);
    const PassOptions pass{.width = 24, .spp = 4};
    EXPECT_EQ(renderer.render(pass).values, Renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 2}, .parameters = {kPainting}}).render(pass).values);
}

TEST(LibraryRenderer, TellsLayersAndShowsImagesAsTheyGrow) {
    Renderer renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 3}});
    PassReport report;
    std::vector<Image> shown;
    const PassOptions pass{.width = 24, .spp = 8};
    PassOptions growing = pass;
    growing.layers = true;
    growing.onImage = [&](const Image& image) { shown.push_back(image); };
    const Image image = renderer.render(growing, &report);
    ASSERT_GE(shown.size(), 2u);
    EXPECT_EQ(shown.back().values, image.values);
    EXPECT_EQ(renderer.render(pass).values, image.values);
    EXPECT_EQ(report.layers.depth.width, 24);
    EXPECT_EQ(report.layers.samples.values.front(), 8);
    EXPECT_GT(report.layers.depth.values.front(), 0);
    EXPECT_FALSE(report.guided);
    EXPECT_EQ(report.paths, 8 * image.pixels());
    EXPECT_GT(report.seconds, 0);
}

TEST(LibraryRenderer, EndsAPassWhenAskedTo) {
    Renderer renderer(device(), Scene::load(kBox));
    const PassOptions pass{.width = 24, .spp = 4, .train = 1};
    const Image image = renderer.render(pass);
    struct Ended {};
    renderer.onSubmission([] { throw Ended{}; });
    EXPECT_THROW(renderer.render(pass), Ended);
    renderer.onSubmission({});
    EXPECT_EQ(renderer.render(pass).values, image.values);
}

// The scene got another size since the renderer's last pass.
TEST(LibraryRenderer, DirectionsAreOfTheSizeThatParametersHaveNow) {
    Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, {.paths = {.maxDepth = 3}, .parameters = {kPainting}});
    const PassOptions pass{.width = 8, .spp = 1};
    int edge = 8;
    const auto along = [&](const auto& use) {
        renderer.render(pass);
        edge *= 2;
        scene.resize(kPainting, edge, edge);
        const Direction direction{kPainting, std::vector<float>(std::size_t(edge) * edge * 3, 1.f)};
        use(direction);
    };
    along([&](const Direction& d) { EXPECT_EQ(renderer.forward(std::span(&d, 1), pass).width, 8); });
    along([&](const Direction& d) { renderer.train(std::span(&d, 1), pass); });
    along([&](const Direction& d) { renderer.check(d, pass, 1); });
    along([&](const Direction& d) {
        Film film(8, 8);
        renderer.forward(film, std::span(&d, 1), pass);
    });
}

TEST(LibraryRenderer, TellsWhatPassesTake) {
    const Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, {.paths = {.maxDepth = 3}, .parameters = {kPainting}});
    renderer.render({.width = 8, .spp = 1});
    const std::uint64_t inUse = device().memoryInUse();
    const auto bytes = [](const Footprint& footprint) {
        std::uint64_t sum = 0;
        for (const auto& [name, size] : footprint.buffers)
            sum += size;
        return sum;
    };
    const Footprint image = renderer.footprint({PassKind::Render}), gradient = renderer.footprint({PassKind::Render, PassKind::Backward});
    EXPECT_EQ(device().memoryInUse(), inUse);
    EXPECT_EQ(bytes(image), inUse); // the device has nothing else
    EXPECT_GT(bytes(gradient), bytes(image));
    EXPECT_GT(gradient.kernels.size(), image.kernels.size());
    for (const Footprint::Kernel& kernel : image.kernels)
        EXPECT_TRUE(kernel.kind == PassKind::Render && kernel.bytes > 0 && kernel.bytes <= kernel.moduleBytes) << kernel.name;
    EXPECT_EQ(renderer.footprint({PassKind::Backward}, {.train = 1}).buffers.count("guide cells"), 1u);
}

TEST(LibraryRenderer, RendersTwoScenesAtOnce) {
    const Scene a = Scene::load(kBox), b = Scene::load(CMPG_SOURCE_DIR "/scenes/furnace/scene.gltf");
    const PassOptions pass{.width = 16, .spp = 2};
    const Image first = Renderer(device(), a).render(pass), second = Renderer(device(), b).render(pass);
    bool same = true;
    std::thread other([&] {
        for (int i = 0; i < 5; ++i)
            same &= Renderer(device(), b).render(pass).values == second.values;
    });
    for (int i = 0; i < 5; ++i)
        EXPECT_EQ(Renderer(device(), a).render(pass).values, first.values);
    other.join();
    EXPECT_TRUE(same);
}

} // namespace
} // namespace cmpg::test
