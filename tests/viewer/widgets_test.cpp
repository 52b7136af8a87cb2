// Text and buttons where there is little room. Needs no display.
#include "viewer/widgets.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <numeric>

namespace cmpg::viewer {
namespace {

// A frame that nobody draws.
class Widgets : public testing::Test {
  protected:
    void SetUp() override {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {480, 320};
        io.Fonts->Build();
        ImGui::NewFrame();
        ImGui::SetNextWindowSize({240, 320});
        ImGui::Begin("controls");
    }
    void TearDown() override {
        ImGui::End();
        ImGui::EndFrame();
        ImGui::DestroyContext();
    }
    static float width(const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; }
};

TEST_F(Widgets, TextIsShortenedToItsRoom) {
    const std::string text = "saved folder/box-image.png";
    EXPECT_EQ(shortened(text, width(text)), text);
    EXPECT_EQ(shortenedAtFront(text, width(text)), text);
    for (float room = 0; room < width(text); room += 3) {
        const std::string head = shortened(text, room), tail = shortenedAtFront(text, room);
        EXPECT_LE(width(head), room);
        EXPECT_LE(width(tail), room);
        if (!head.empty()) {
            EXPECT_EQ(head, text.substr(0, head.size() - 3) + "...");
            EXPECT_EQ(tail, "..." + text.substr(text.size() - (tail.size() - 3)));
        }
    }
    // Letters of several bytes stay whole.
    const std::string letters = "\xc3\xa4\xc3\xb6\xc3\xbc\xc3\xa4\xc3\xb6\xc3\xbc";
    for (float room = 0; room < width(letters); ++room) {
        EXPECT_EQ(shortened(letters, room).size() % 2, shortened(letters, room).empty() ? 0u : 1u);
        EXPECT_EQ(shortenedAtFront(letters, room).size() % 2, shortenedAtFront(letters, room).empty() ? 0u : 1u);
    }
}

TEST_F(Widgets, ButtonsShareALine) {
    const char* const labels[] = {"Render", "Gradient", "Optimise"};
    const std::vector<float> widths = widthsOfButtons(labels);
    const float all = std::accumulate(widths.begin(), widths.end(), 2 * ImGui::GetStyle().ItemSpacing.x), room = ImGui::GetContentRegionAvail().x;
    EXPECT_LE(all, room);
    EXPECT_GT(all, room - 3);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_GE(widths[i], width(labels[i]));
}

TEST_F(Widgets, AFigureWithoutRoomStandsBelowItsLabel) {
    const float line = ImGui::GetTextLineHeightWithSpacing();
    float top = ImGui::GetCursorPosY();
    figure("step", "12");
    EXPECT_FLOAT_EQ(ImGui::GetCursorPosY(), top + line);
    top = ImGui::GetCursorPosY();
    figure("learned from", "1234 passes, 123456 cells");
    EXPECT_FLOAT_EQ(ImGui::GetCursorPosY(), top + 2 * line);
}

TEST_F(Widgets, AListWithoutRoomStandsBelowItsLabel) {
    const auto below = [](const std::string& chosen) {
        const float top = ImGui::GetCursorPosY();
        beginField("sampling", chosen);
        const bool moved = ImGui::GetCursorPosY() > top;
        ImGui::Dummy({1, 1});
        return moved;
    };
    EXPECT_FALSE(below(""));
    EXPECT_FALSE(below("auto"));
    EXPECT_TRUE(below("a list of far longer choices"));
}

} // namespace
} // namespace cmpg::viewer
