// Letters of names in files. Needs no display.
#include "viewer/theme.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <imgui.h>

namespace cmpg::viewer {
namespace {

TEST(Theme, HasTheLettersOfManyLanguages) {
    if (!std::filesystem::exists("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"))
        GTEST_SKIP() << "DejaVu is not installed";
    ImGui::CreateContext();
    applyTheme(1);
    ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    ASSERT_TRUE(fonts.Build());
    for (const ImWchar letter : {0x00e4, 0x0142, 0x0151, 0x021b, 0x03bb, 0x0436, 0x2212})
        EXPECT_TRUE(fonts.Fonts[0]->FindGlyphNoFallback(letter)) << std::hex << letter;
    ImGui::DestroyContext();
}

} // namespace
} // namespace cmpg::viewer
