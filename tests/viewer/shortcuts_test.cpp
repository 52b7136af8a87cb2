// Keys, whoever has the focus. Needs no display.
#include "viewer/shortcuts.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>
#include <imgui.h>

namespace cmpg::viewer {
namespace {

TEST(Shortcuts, AFieldOfTextTakesAllButTheEnd) {
    ImGui::CreateContext();
    ImGui::GetIO().WantTextInput = true;
    LiveSession session{Options{}};
    Desk desk(session);
    const KeyPress letter{GLFW_KEY_L, false, false}, q{GLFW_KEY_Q, false, false}, end{GLFW_KEY_Q, true, false};
    handleKeys(desk, std::array{letter, q});
    EXPECT_FALSE(desk.layers);
    EXPECT_FALSE(desk.quit);
    handleKeys(desk, std::array{letter, end});
    EXPECT_FALSE(desk.layers);
    EXPECT_TRUE(desk.quit);
    ImGui::DestroyContext();
}

} // namespace
} // namespace cmpg::viewer
