// What the window asks the work for by itself. Needs no display.
#include "viewer/desk.h"

#include <gtest/gtest.h>
#include <thread>
#include <unistd.h>

namespace cmpg::viewer {
namespace {

template <class Wanted> bool waitFor(Wanted&& wanted) {
    for (int i = 0; i < 4800 && !wanted(); ++i) // four minutes: kernels are compiled
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return wanted();
}

// A window on the box, 24 x 24, after a click on a pixel.
struct BoxDesk {
    LiveSession session{optionsOfBox()};
    Desk desk{session};

    BoxDesk(int x, int y) {
        EXPECT_TRUE(waitFor([&] { return session.state()->imageSamples > 0; }));
        desk.inspector = true;
        session.pick(x, y);
        EXPECT_TRUE(waitFor([&] { return session.state()->pick != nullptr; }));
    }

  private:
    static Options optionsOfBox() {
        Options options;
        options.input = std::string(CMPG_SOURCE_DIR) + "/scenes/box/scene.gltf";
        options.width = options.height = 24;
        options.spp = 4;
        return options;
    }
};

TEST(Desk, LooksAgainWhereTheGuideLearnedBeforeThePickWasSeen) {
    BoxDesk box(12, 12);
    LiveSession& session = box.session;
    Desk& desk = box.desk;
    ASSERT_NE(session.state()->pick, nullptr);
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

TEST(Desk, LooksAgainAtTheSamePointInAnotherSize) {
    BoxDesk box(20, 5);
    LiveSession& session = box.session;
    Desk& desk = box.desk;
    ASSERT_NE(session.state()->pick, nullptr);
    const auto before = session.state()->pick;
    ASSERT_TRUE(before->hit);
    session.change([](LiveSettings& s) { s.width = s.height = 72; });
    session.train();
    ASSERT_TRUE(waitFor([&] { return session.state()->guidePasses == 1; }));
    desk.update();
    ASSERT_TRUE(waitFor([&] { return session.state()->pick->number == 2; }));
    const auto after = session.state()->pick;
    EXPECT_EQ(after->x, 61); // the middle of the nine
    EXPECT_EQ(after->y, 16);
    EXPECT_EQ(after->width, 72);
    EXPECT_LT(glm::length(after->position - before->position), 1e-4f);
}

TEST(Desk, AnotherSceneListsAllItsParameters) {
    const std::filesystem::path scenes(CMPG_SOURCE_DIR "/scenes");
    Options options;
    options.input = (scenes / "materials/scene.gltf").string();
    options.width = options.height = 24;
    options.spp = 1;
    LiveSession session(options);
    Desk desk(session);
    const auto opened = [&](std::uint32_t number) {
        return waitFor([&] {
            desk.update();
            return desk.state->scene && desk.state->scene->number == number;
        });
    };
    ASSERT_TRUE(opened(1));
    desk.wanted = "roughness";
    desk.update();
    EXPECT_EQ(desk.wanted, "roughness");
    desk.open({scenes / "bowl/scene.gltf"});
    ASSERT_TRUE(opened(2));
    EXPECT_EQ(desk.wanted, "");
}

TEST(Desk, StandsALostWorkingFolder) {
    LiveSession session{Options{}};
    Desk desk(session);
    LiveState state;
    auto scene = std::make_shared<LiveScene>();
    scene->file = "room/scene.gltf";
    state.scene = scene;
    desk.state = std::make_shared<const LiveState>(state);
    desk.folder = "/pictures";
    const std::filesystem::path before = std::filesystem::current_path();
    const std::filesystem::path gone = std::filesystem::temp_directory_path() / ("cmpg-gone-" + std::to_string(getpid()));
    std::filesystem::create_directory(gone);
    std::filesystem::current_path(gone);
    std::filesystem::remove(gone);
    EXPECT_NO_THROW(EXPECT_EQ(desk.sceneName(), "room/scene.gltf"));
    EXPECT_NO_THROW(EXPECT_EQ(desk.fileFor("image", ".png"), "/pictures/room-image.png"));
    std::filesystem::current_path(before);
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
