// What the window asks the work for by itself. Needs no display.
#include "viewer/desk.h"

#include <gtest/gtest.h>
#include <thread>

namespace cmpg::viewer {
namespace {

template <class Wanted> bool waitFor(Wanted&& wanted) {
    for (int i = 0; i < 4800 && !wanted(); ++i) // four minutes: kernels are compiled
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return wanted();
}

TEST(Desk, LooksAgainWhereTheGuideLearnedBeforeThePickWasSeen) {
    Options options;
    options.input = std::string(CMPG_SOURCE_DIR) + "/scenes/box/scene.gltf";
    options.width = options.height = 24;
    options.spp = 4;
    LiveSession session(options);
    Desk desk(session);
    ASSERT_TRUE(waitFor([&] { return session.state()->imageSamples > 0; }));
    desk.inspector = true;
    session.pick(12, 12);
    ASSERT_TRUE(waitFor([&] { return session.state()->pick != nullptr; }));
    ASSERT_TRUE(session.state()->pick->hit);
    ASSERT_FALSE(session.state()->pick->guide);
    session.train();
    ASSERT_TRUE(waitFor([&] { return session.state()->guidePasses == 1; }));
    // Only now comes a frame, as on a busy machine.
    desk.update();
    EXPECT_TRUE(waitFor([&] { return session.state()->pick->number == 2; }));
    EXPECT_TRUE(session.state()->pick->guide);
    for (int i = 0; i < 10; ++i) {
        desk.update();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(session.state()->pick->number, 2u); // it is asked for once
}

TEST(Desk, TheLastErrorCountsUntilSomethingOpens) {
    const std::filesystem::path scenes(CMPG_SOURCE_DIR "/scenes");
    Options options;
    options.input = (scenes / "box/scene.gltf").string();
    options.width = options.height = 24;
    options.spp = 1;
    LiveSession session(options);
    Desk desk(session);
    const auto shows = [&](auto&& wanted) {
        return waitFor([&] {
            desk.update();
            return wanted();
        });
    };
    ASSERT_TRUE(shows([&] { return desk.state->imageSamples > 0; }));
    desk.open({"nowhere.gltf"});
    EXPECT_TRUE(shows([&] { return desk.openError() != nullptr; }));
    desk.open({scenes / "README.md"});
    EXPECT_FALSE(desk.openError());
    EXPECT_NE(desk.fileError.find("README.md"), std::string::npos);
    desk.open({"nothing.exr"});
    EXPECT_TRUE(shows([&] { return desk.openError() && desk.openError()->what.find("nothing.exr") != std::string::npos; }));
    EXPECT_EQ(desk.fileError, "");
    desk.open({scenes / "bowl/scene.gltf"});
    EXPECT_TRUE(shows([&] { return desk.state->scene->number == 2; }));
    EXPECT_FALSE(desk.openError());
    desk.open({"nothing.exr"});
    EXPECT_TRUE(shows([&] { return desk.openError() != nullptr; }));
    desk.closeError();
    EXPECT_FALSE(desk.openError());
}

} // namespace
} // namespace cmpg::viewer
