// Recoveries that go on from a checkpoint, or from the progress of another.
#include "library_fixture.h"

namespace cmpg::test {
namespace {

TEST(LibraryRecovery, GoesOnFromACheckpointToTheSameBits) {
    const Folder folder;
    const Scene scene = greyScene();
    const std::vector<Target> targets{smallTarget()};
    Recovery whole(device(), scene, targets, paintingOptions()), half(device(), scene, targets, paintingOptions());
    for (int i = 0; i < 4; ++i)
        whole.step();
    for (int i = 0; i < 2; ++i)
        half.step();
    EXPECT_GT(half.save(folder / "kept"), 64u * 64 * 3 * sizeof(float));
    Recovery resumed(device(), scene, targets, paintingOptions());
    EXPECT_FALSE(resumed.resume(folder / "none"));
    std::vector<Warning> warnings;
    ASSERT_TRUE(resumed.resume(folder / "kept", &warnings));
    EXPECT_TRUE(warnings.empty()) << warnings.front().text;
    EXPECT_EQ(resumed.steps(), 2u);
    ASSERT_EQ(resumed.history().size(), 2u);
    for (int i = 0; i < 2; ++i)
        resumed.step();
    EXPECT_EQ(resumed.values(kPainting), whole.values(kPainting));
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(resumed.history().at(i).loss, whole.history().at(i).loss);

    RecoveryOptions others = paintingOptions();
    others.sppGradient = 8;
    Recovery other(device(), scene, targets, others);
    const Error error = errorOf([&] { other.resume(folder / "kept"); });
    EXPECT_EQ(error.kind, ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("spp-gradient differs: it has 4, this one 8"), std::string::npos) << error.what();
    EXPECT_EQ(error.options, (std::vector<std::string>{"spp-gradient", "resume"}));
    Recovery beside(device(), scene, {smallTarget(2)}, paintingOptions());
    const Error of = errorOf([&] { beside.resume(folder / "kept"); });
    EXPECT_EQ(of.kind, ErrorKind::Input);
    EXPECT_NE(std::string(of.what()).find("the target differs"), std::string::npos) << of.what();
}

// Before its first step, too, as a loop does that keeps what it has before each.
TEST(LibraryRecovery, KeepsWhatWentOnFromAnother) {
    const Folder folder;
    Scene scene = greyScene();
    const std::vector<Target> targets{smallTarget()};
    Renderer renderer(device(), scene, paintingRenderer());
    Recovery first(renderer, targets, paintingOptions());
    first.step();
    first.step();
    const std::vector<float> values = first.values(kPainting);
    const RecoveryProgress progress = first.progress();
    Recovery next(renderer, targets, paintingOptions(), progress);
    next.save(folder / "begun");
    next.step();
    next.save(folder / "kept");
    ASSERT_EQ(next.history().size(), 1u);
    EXPECT_EQ(next.history()[0].step, 2u);

    scene.set(kPainting, values); // the renderer has those of the other recovery
    Recovery again(renderer, targets, paintingOptions(), progress);
    ASSERT_TRUE(again.resume(folder / "kept"));
    EXPECT_EQ(again.steps(), 3u);
    EXPECT_EQ(again.values(kPainting), next.values(kPainting));
    EXPECT_EQ(again.history().at(0).step, 2u);
    ASSERT_TRUE(again.resume(folder / "begun"));
    EXPECT_EQ(again.steps(), 2u);
    again.step();
    EXPECT_EQ(again.values(kPainting), next.values(kPainting));
}

// Moments are of the loss and the targets that they came from: with others, what went before says how many steps there were and no more.
TEST(LibraryRecovery, BeginsAnewForAnotherObjective) {
    Scene scene = greyScene();
    Renderer renderer(device(), scene, paintingRenderer());
    const auto after = [&](float start, Loss loss) { // a step that goes on where two others were
        scene.set(kPainting, std::vector{start});
        Recovery before(renderer, {smallTarget()}, paintingOptions());
        before.step();
        before.step();
        scene.set(kPainting, std::vector{0.5f});
        RecoveryOptions then = paintingOptions();
        then.loss = loss;
        Recovery recovery(renderer, {smallTarget()}, then, before.progress());
        recovery.step();
        return recovery.values(kPainting);
    };
    EXPECT_NE(after(0.2f, Loss::Mse), after(0.8f, Loss::Mse)) << "these tell of the same";
    EXPECT_EQ(after(0.2f, Loss::RelativeMse), after(0.8f, Loss::RelativeMse));
}

TEST(LibraryRecovery, LearnsAgainWhereItResumesBeforeTheFreeze) {
    const Folder folder;
    RecoveryOptions options = paintingOptions();
    options.paths.sampling = Sampling::Conditional;
    options.freeze = 2;
    Recovery recovery(device(), greyScene(), {smallTarget()}, options);
    recovery.step();
    recovery.save(folder / "kept");
    for (int i = 0; i < 2; ++i)
        recovery.step();
    const std::vector<float> values = recovery.values(kPainting);
    ASSERT_TRUE(recovery.resume(folder / "kept"));
    for (int i = 0; i < 2; ++i)
        recovery.step();
    EXPECT_EQ(recovery.values(kPainting), values);
}

} // namespace
} // namespace cmpg::test
