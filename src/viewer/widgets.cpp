// Small parts of the interface that look alike everywhere.
#include "viewer/widgets.h"

#include "base/utf8.h"
#include "viewer/theme.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

float columnOffset() {
    return 8.6f * ImGui::GetFontSize();
}

float widthOf(const std::string& text) {
    return ImGui::CalcTextSize(text.c_str()).x;
}

} // namespace

void section(const char* title) {
    ImGui::Spacing();
    ImGui::Separator();
    ImGui::TextColored(kAccent, "%s", title);
}

std::string shortened(const std::string& text, float width) {
    if (widthOf(text) <= width)
        return text;
    std::string head = text;
    while (!head.empty() && widthOf(head + "...") > width) {
        while (head.size() > 1 && continuesCharacter(head.back()))
            head.pop_back();
        head.pop_back();
    }
    return head.empty() ? "" : head + "...";
}

std::string shortenedAtFront(const std::string& text, float width) {
    if (widthOf(text) <= width)
        return text;
    std::size_t from = 0;
    while (from < text.size() && widthOf("..." + text.substr(from)) > width)
        do
            ++from;
        while (from < text.size() && continuesCharacter(text[from]));
    return from == text.size() ? "" : "..." + text.substr(from);
}

void figure(const char* label, const std::string& value) {
    const float left = ImGui::GetCursorPosX(), right = left + ImGui::GetContentRegionAvail().x, width = widthOf(value);
    ImGui::TextColored(kDim, "%s", label);
    if (columnOffset() + width <= right)
        ImGui::SameLine(columnOffset());
    else
        ImGui::SetCursorPosX(std::max(left, right - width));
    ImGui::TextUnformatted(value.c_str());
}

bool beginField(const char* label, const std::string& chosen) {
    const float right = ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x;
    const float needed = chosen.empty() ? 0 : widthOf(chosen) + 2 * ImGui::GetStyle().FramePadding.x + ImGui::GetFrameHeight();
    ImGui::AlignTextToFramePadding();
    ImGui::TextColored(kDim, "%s", label);
    if (columnOffset() + needed <= right)
        ImGui::SameLine(columnOffset());
    ImGui::SetNextItemWidth(-1);
    return true;
}

std::vector<float> widthsOfButtons(std::span<const char* const> labels) {
    const float count = float(labels.size());
    float left = ImGui::GetContentRegionAvail().x - (count - 1) * ImGui::GetStyle().ItemSpacing.x;
    for (const char* label : labels)
        left -= widthOf(label);
    std::vector<float> widths;
    for (const char* label : labels)
        widths.push_back(std::max(1.f, std::floor(widthOf(label) + left / count)));
    return widths;
}

bool button(const char* label, float width) {
    constexpr float kLeastMargin = 2;
    const ImVec2 margins = ImGui::GetStyle().FramePadding;
    const std::string shown = shortened(label, width - 2 * kLeastMargin);
    const float margin = std::clamp(0.5f * (width - widthOf(shown)), 0.f, margins.x);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {margin, margins.y});
    const bool clicked = ImGui::Button((shown + "###" + label).c_str(), {width, 0});
    ImGui::PopStyleVar();
    if (shown != label)
        tip(label);
    return clicked;
}

bool choiceButton(const char* label, bool chosen, float width) {
    if (chosen) {
        ImGui::PushStyleColor(ImGuiCol_Button, kAccent);
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, kAccent);
        ImGui::PushStyleColor(ImGuiCol_ButtonActive, kAccent);
        ImGui::PushStyleColor(ImGuiCol_Text, {0.08f, 0.08f, 0.08f, 1});
    }
    const bool clicked = button(label, width);
    if (chosen)
        ImGui::PopStyleColor(4);
    return clicked;
}

void tip(const char* text) {
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", text);
}

} // namespace cmpg::viewer
