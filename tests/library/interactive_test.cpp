// What programs use that look on while they render and recover: films, moved cameras, picks, what the guide knows, recoveries of a renderer.
#include "library_fixture.h"

#include <algorithm>
#include <cmath>

namespace cmpg::test {
namespace {

struct Ended {};

std::vector<Direction> brighter(const Scene& scene) { return {{kPainting, std::vector<float>(scene.parameter(kPainting).entries(), 1.f)}}; }

TEST(LibraryFilm, PassesLeaveTheBitsOfOne) {
    const Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, paintingRenderer(false));
    PassReport report;
    const Image image = renderer.render({.width = 24, .height = 16, .spp = 13, .seed = 5, .layers = true}, &report);
    Film film(24, 16, true), derivative(24, 16);
    EXPECT_EQ(errorOf([&] { film.image(); }).kind, ErrorKind::Usage);
    for (const std::uint32_t spp : {1u, 7u, 5u}) {
        renderer.render(film, {.spp = spp, .seed = 5});
        renderer.forward(derivative, brighter(scene), {.spp = spp, .seed = 5});
    }
    EXPECT_EQ(film.samples(), 13u);
    EXPECT_EQ(film.image().values, image.values);
    EXPECT_EQ(film.layers().normal.values, report.layers.normal.values);
    EXPECT_EQ(film.layers().depth.values, report.layers.depth.values);
    EXPECT_EQ(derivative.image().values, renderer.forward(brighter(scene), {.width = 24, .height = 16, .spp = 13, .seed = 5}).values);
    // Frames of a seed have numbers of their own.
    EXPECT_NE(renderer.render({.width = 24, .height = 16, .spp = 13, .seed = 5, .frame = 1}).values, image.values);
}

TEST(LibraryFilm, IsAsItWasWhereAPassIsEnded) {
    const Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, paintingRenderer());
    Film film(64, 64);
    renderer.render(film, {.spp = 2});
    const Image before = film.image();
    int calls = 0;
    renderer.onSubmission(
        [&] {
            if (++calls == 3)
                throw Ended();
        },
        0.02);
    EXPECT_THROW(renderer.render(film, {.spp = 4096}), Ended);
    EXPECT_EQ(film.samples(), 2u);
    EXPECT_EQ(film.image().values, before.values);
    renderer.onSubmission({});
    renderer.render(film, {.spp = 3});
    EXPECT_EQ(film.image().values, renderer.render({.width = 64, .height = 64, .spp = 5}).values);
}

TEST(LibraryFilm, RefusesWhatMakesNoSense) {
    Renderer renderer(device(), Scene::load(kBox));
    Film film(8, 8);
    for (const PassOptions& pass : {PassOptions{.width = 9}, PassOptions{.train = 1}, PassOptions{.batches = 8}, PassOptions{.frozen = true}})
        EXPECT_EQ(errorOf([&] { renderer.render(film, pass); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { Film none(0, 8); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { film.layers(); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { renderer.setSampling(Sampling::Bsdf); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { renderer.onSubmission({}, 0); }).kind, ErrorKind::Usage);
}

TEST(LibraryCamera, SeesFromElsewhereAndPicksWhatItSees) {
    const Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, paintingRenderer(false));
    CameraInfo camera = scene.cameras().front();
    PassReport report;
    const Image image = renderer.render({.from = camera, .width = 32, .height = 24, .spp = 64, .layers = true}, &report);
    EXPECT_EQ(image.values, renderer.render({.width = 32, .height = 24, .spp = 64}).values);
    int near = 0;
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 32; ++x) {
            const std::optional<SurfacePoint> point = scene.pick(camera, 32, 24, float(x) + 0.5f, float(y) + 0.5f);
            const float depth = *report.layers.depth.at(x, y);
            near += point ? std::abs(point->distance - depth) < 0.02f * depth && !point->material.empty() : depth == 0;
        }
    EXPECT_GT(near, 32 * 24 * 4 / 5); // all but those at edges
    camera.toWorld[12] += 0.05f;
    EXPECT_NE(renderer.render({.from = camera, .width = 32, .height = 24, .spp = 64}).values, image.values);
    CameraInfo wide = camera;
    wide.aspect = 2;
    EXPECT_EQ(renderer.render({.from = wide, .width = 32, .spp = 1}).height, 16);
    EXPECT_EQ(scene.pick(wide, 32, 0, 16.5f, 8.5f)->position, scene.pick(camera, 32, 16, 16.5f, 8.5f)->position);
    for (const float aspect : {0.f, -1.f, NAN, INFINITY}) {
        wide.aspect = aspect;
        EXPECT_EQ(errorOf([&] { renderer.render({.from = wide, .width = 8}); }).options, std::vector<std::string>{"camera"});
    }
    camera.toWorld[12] = NAN;
    EXPECT_EQ(errorOf([&] { renderer.render({.from = camera, .width = 8}); }).kind, ErrorKind::Usage);
    const SceneBox box = scene.box();
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_LT(box.lower[std::size_t(axis)], box.upper[std::size_t(axis)]);
    EXPECT_EQ(scene.imageSize("", 64, 48), std::pair(64, 48));
    EXPECT_EQ(scene.imageSize().first, 512);
}

TEST(LibraryGuide, LearnsAPassAtATimeAndTellsWhatItKnows) {
    const Scene scene = Scene::load(CMPG_SOURCE_DIR "/scenes/door/scene.gltf");
    const PassOptions pass{.width = 24, .height = 24, .spp = 8, .seed = 3, .train = 1};
    PassOptions three = pass;
    three.train = 3;
    three.trainSpp = pass.spp;
    Renderer renderer(device(), scene, paintingRenderer()), whole(device(), scene, paintingRenderer(false));
    EXPECT_FALSE(renderer.guideAt({0, 0, 0}, PassKind::Forward));
    int compiled = 0;
    renderer.onCompile([&](bool begins) { compiled += begins; });
    for (int i = 0; i < 3; ++i)
        renderer.train(brighter(scene), pass);
    EXPECT_GT(compiled, 0);
    Film film(24, 24, true);
    PassReport report;
    renderer.forward(film, brighter(scene), {.spp = 8, .seed = 3}, &report);
    EXPECT_EQ(film.image().values, whole.forward(brighter(scene), three).values);
    EXPECT_EQ(report.guideUpdates, 3u);
    EXPECT_EQ(report.guideCells, renderer.report().guideCells);

    Film seen(24, 24, true);
    renderer.render(seen, {.spp = 4, .seed = 3});
    const std::optional<Image> cells = renderer.guideCells(seen.layers().depth, {});
    ASSERT_TRUE(cells);
    EXPECT_LT(*std::max_element(cells->values.begin(), cells->values.end()), float(report.guideCells));
    const std::optional<SurfacePoint> point = scene.pick(scene.cameras().front(), 24, 24, 12.5f, 12.5f);
    ASSERT_TRUE(point);
    const std::optional<GuidePoint> guide = renderer.guideAt(point->position, PassKind::Forward);
    ASSERT_TRUE(guide);
    EXPECT_EQ(guide->cells, report.guideCells);
    const Image map = guide->density({1, 0, 0}, 32);
    double mean = 0;
    for (const float v : map.values)
        mean += double(v) / double(map.pixels());
    EXPECT_TRUE(mean == 0 || std::abs(mean - 1) < 1e-3) << mean;
    EXPECT_EQ(errorOf([&] { guide->density({1, 0, 0}, 33); }).kind, ErrorKind::Usage);

    renderer.forget();
    EXPECT_FALSE(renderer.guideAt(point->position, PassKind::Forward));
    for (int i = 0; i < 3; ++i) // the same numbers again
        renderer.train(brighter(scene), pass);
    Film again(24, 24);
    renderer.forward(again, brighter(scene), {.spp = 8, .seed = 3});
    EXPECT_EQ(again.image().values, film.image().values);
}

TEST(LibraryInteractive, ARecoveryOfARendererIsThatOfADevice) {
    const std::vector<Target> targets{smallTarget()};
    const Scene own = greyScene(), scene = greyScene();
    RecoveryOptions options = paintingOptions();
    options.steps = 4;
    Recovery alone(device(), own, targets, options);
    Renderer renderer(device(), scene, paintingRenderer());
    Recovery recovery(renderer, targets, options);
    EXPECT_EQ(errorOf([&] { Recovery(Renderer(device(), scene, paintingRenderer(false)), targets, options); }).kind, ErrorKind::Usage);
    int calls = 0;
    recovery.onSubmission(
        [&] {
            if (++calls == 4)
                throw Ended();
        },
        0.02);
    EXPECT_THROW(recovery.step(), Ended);
    EXPECT_EQ(recovery.steps(), 0u);
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(recovery.step().loss, alone.step().loss);
        EXPECT_EQ(scene.values(kPainting), alone.values(kPainting)); // the scene's own
        EXPECT_EQ(recovery.gradient(kPainting), alone.gradient(kPainting));
        Film between(16, 16); // leaves no trace
        renderer.render(between, {.spp = 2});
    }
    Film film(32, 32);
    recovery.image(film, 0, 3);
    recovery.image(film, 0, 6);
    EXPECT_EQ(film.image().values, recovery.image(0, 9).values);
    Film layered(32, 32, true);
    recovery.image(layered, 0, 9);
    EXPECT_EQ(layered.image().values, film.image().values);
}

TEST(LibraryInteractive, GoesOnWhereARecoveryEnded) {
    Scene scene = greyScene();
    RecoveryOptions options = paintingOptions();
    std::vector<Target> targets{smallTarget()};
    targets.front().from = scene.cameras().front();
    Renderer renderer(device(), scene, paintingRenderer());
    Recovery recovery(renderer, targets, options);
    recovery.setSamples(8, 2);
    recovery.step();
    recovery.setRateFactor(0);
    const std::vector<float> values = scene.values(kPainting);
    recovery.step();
    EXPECT_EQ(scene.values(kPainting), values);
    scene.set(kPainting, std::vector{0.25f}); // taken over
    recovery.step();
    EXPECT_EQ(recovery.values(kPainting), std::vector<float>(values.size(), 0.25f));

    renderer.setSampling(Sampling::Conditional);
    EXPECT_TRUE(recovery.ended());
    EXPECT_EQ(errorOf([&] { recovery.step(); }).kind, ErrorKind::Usage);
    RendererOptions both = paintingRenderer();
    both.parameters.push_back("white.baseColor");
    Recovery next(Renderer(device(), scene, both), targets, options, recovery.progress());
    EXPECT_EQ(next.steps(), 3u);
    EXPECT_EQ(next.step().step, 3u);
    EXPECT_NE(scene.values(kPainting), std::vector<float>(values.size(), 0.25f));

    const Folder folder;
    const std::vector<std::string> none;
    EXPECT_TRUE(std::filesystem::exists(scene.exportTo(folder / "scene", none)));
    EXPECT_FALSE(std::filesystem::exists(folder / "scene/parameters/painting.baseColor.exr"));
}

// A call back comes amidst a pass or a step, which uses buffers and values of the renderer.
TEST(LibraryInteractive, CallBacksMayNotAskForOtherWork) {
    const Scene scene = greyScene();
    Renderer renderer(device(), scene, paintingRenderer()), other(device(), scene, {.paths = paintingOptions().paths});
    const Image alone = renderer.render({.width = 24, .spp = 4}), others = other.render({.width = 16, .spp = 2});
    Recovery recovery(renderer, {smallTarget()}, paintingOptions());
    const Folder folder;
    const std::vector<std::function<void()>> refused{
        [&] { renderer.render({.width = 16, .spp = 1}); },  [&] { renderer.forget(); },     [&] { renderer.setSampling(Sampling::Bsdf); },
        [&] { renderer.prepare({PassKind::Forward}, {}); }, [&] { recovery.step(); },       [&] { recovery.image(0, 1); },
        [&] { recovery.save(folder / "run"); },             [&] { Film f(8, 8); renderer.render(f, {.spp = 1}); },
    };
    std::size_t asked = 0;
    const auto ask = [&] {
        if (asked == refused.size())
            return;
        const Error error = errorOf(refused[asked++]);
        EXPECT_EQ(error.kind, ErrorKind::Usage);
        EXPECT_NE(std::string(error.what()).find("at work"), std::string::npos) << error.what();
        renderer.report(PassKind::Render); // what is known may be asked for
        EXPECT_EQ(other.render({.width = 16, .spp = 2}).values, others.values); // and another renderer be used
    };
    renderer.onSubmission(ask, 0.001);
    while (asked < refused.size())
        EXPECT_EQ(renderer.render({.width = 24, .spp = 4}).values, alone.values);
    renderer.onSubmission({});
    int shown = 0;
    recovery.onImage([&](std::size_t, const Image&) {
        ++shown;
        EXPECT_EQ(errorOf([&] { renderer.render({.width = 16, .spp = 1}); }).kind, ErrorKind::Usage);
    });
    recovery.step();
    EXPECT_EQ(shown, 1);
}

// Moments of another method, or of a texture of another size, mean something else: what was before makes no difference to such a step.
TEST(LibraryInteractive, BeginsAnewByAnotherMethodAndWithAnotherSize) {
    struct How {
        OptimizerKind kind;
        int edge;
    };
    Scene scene = greyScene();
    RendererOptions unguided = paintingRenderer(); // what a guide learned goes on, and changes noise
    unguided.paths.sampling = Sampling::Bsdf;
    unguided.paths.roulette = false;
    Renderer renderer(device(), scene, unguided);
    const std::vector<Target> targets{smallTarget()};
    const auto options = [](OptimizerKind kind) {
        RecoveryOptions o = paintingOptions();
        o.spp = o.sppGradient = 2;
        o.optimizer = kind;
        return o;
    };
    const auto begin = [&](int edge, float value) {
        scene.resize(kPainting, edge, edge);
        scene.set(kPainting, std::vector{value});
    };
    const auto after = [&](float start, How first, How then) {
        begin(first.edge, start);
        Recovery before(renderer, targets, options(first.kind));
        before.step();
        before.step();
        begin(then.edge, 0.5f);
        Recovery recovery(renderer, targets, options(then.kind), before.progress());
        recovery.step();
        return recovery.values(kPainting);
    };
    const How adam{OptimizerKind::Adam, 32}, finer{OptimizerKind::Adam, 48}, gaussNewton{OptimizerKind::GaussNewton, 32}, sgd{OptimizerKind::Sgd, 32};
    EXPECT_NE(after(0.2f, adam, adam), after(0.8f, adam, adam)) << "these tell of the same";
    for (const auto& [first, then] : {std::pair(adam, finer), std::pair(finer, adam), std::pair(gaussNewton, adam), std::pair(adam, gaussNewton), std::pair(sgd, adam)}) {
        SCOPED_TRACE(testing::Message() << int(first.kind) << ' ' << first.edge << ", " << int(then.kind) << ' ' << then.edge);
        const std::vector<float> values = after(0.2f, first, then);
        EXPECT_EQ(values.size(), std::size_t(then.edge) * std::size_t(then.edge) * 3);
        EXPECT_EQ(values, after(0.8f, first, then));
    }
}

} // namespace
} // namespace cmpg::test
