// How the interface looks: fonts and colours, for the scale of the display.
#include "viewer/theme.h"

#include <cmath>
#include <filesystem>

namespace cmpg::viewer {
namespace {

constexpr float kFontPixels = 15; // at scale 1

// Latin, Greek and Cyrillic, of which names in files are made; the minus sign, arrows and what else the labels use.
constexpr ImWchar kGlyphs[] = {0x0020, 0x024f, 0x0370, 0x04ff, 0x2010, 0x2026, 0x2190, 0x2193, 0x2202, 0x2202, 0x2212, 0x2212, 0};

// DejaVu is where scripts/install puts it; without it the built-in font is legible too.
void loadFont(float pixels) {
    ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    fonts.Clear();
    const char* const file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    std::error_code error;
    if (std::filesystem::exists(file, error) && fonts.AddFontFromFileTTF(file, pixels, nullptr, kGlyphs))
        return;
    ImFontConfig builtIn;
    builtIn.SizePixels = pixels;
    fonts.AddFontDefault(&builtIn);
}

} // namespace

void applyTheme(float scale) {
    loadFont(std::round(kFontPixels * scale));
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = style.ChildRounding = style.PopupRounding = 4;
    style.FrameRounding = style.GrabRounding = 3;
    style.WindowBorderSize = 0;
    style.FramePadding = {7, 4};
    style.ItemSpacing = {8, 6};
    style.WindowPadding = {12, 12};
    style.ScrollbarSize = 12;
    style.GrabMinSize = 12;
    auto& colors = style.Colors;
    const ImVec4 panel{0.135f, 0.135f, 0.145f, 1}, field{0.205f, 0.205f, 0.22f, 1}, hover{0.27f, 0.27f, 0.29f, 1}, active{0.34f, 0.34f, 0.37f, 1};
    colors[ImGuiCol_Text] = kInk;
    colors[ImGuiCol_TextDisabled] = kDim;
    colors[ImGuiCol_WindowBg] = panel;
    colors[ImGuiCol_PopupBg] = {0.12f, 0.12f, 0.13f, 0.98f};
    colors[ImGuiCol_FrameBg] = colors[ImGuiCol_Button] = colors[ImGuiCol_Header] = field;
    colors[ImGuiCol_FrameBgHovered] = colors[ImGuiCol_ButtonHovered] = colors[ImGuiCol_HeaderHovered] = hover;
    colors[ImGuiCol_FrameBgActive] = colors[ImGuiCol_ButtonActive] = colors[ImGuiCol_HeaderActive] = active;
    colors[ImGuiCol_CheckMark] = kAccent;
    colors[ImGuiCol_SliderGrab] = {0.60f, 0.40f, 0.19f, 1}; // numbers stand over it
    colors[ImGuiCol_SliderGrabActive] = {0.72f, 0.48f, 0.22f, 1};
    colors[ImGuiCol_Separator] = {0.25f, 0.25f, 0.27f, 1};
    colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = colors[ImGuiCol_TitleBgCollapsed] = field;
    colors[ImGuiCol_PlotLines] = kAccent;
    style.ScaleAllSizes(scale);
    ImGui::GetStyle() = style;
}

} // namespace cmpg::viewer
