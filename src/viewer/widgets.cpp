// Small parts of the interface that look alike everywhere.
#include "viewer/widgets.h"

#include "viewer/theme.h"

namespace cmpg::viewer {
namespace {

float columnOffset() {
    return 8.6f * ImGui::GetFontSize();
}

} // namespace

void section(const char* title) {
    ImGui::Spacing();
    ImGui::Separator();
    ImGui::TextColored(kAccent, "%s", title);
}

void figure(const char* label, const std::string& value) {
    ImGui::TextColored(kDim, "%s", label);
    ImGui::SameLine(columnOffset());
    ImGui::TextUnformatted(value.c_str());
}

bool beginField(const char* label) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextColored(kDim, "%s", label);
    ImGui::SameLine(columnOffset());
    ImGui::SetNextItemWidth(-1);
    return true;
}

bool choiceButton(const char* label, bool chosen, float width) {
    if (chosen) {
        ImGui::PushStyleColor(ImGuiCol_Button, kAccent);
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, kAccent);
        ImGui::PushStyleColor(ImGuiCol_ButtonActive, kAccent);
        ImGui::PushStyleColor(ImGuiCol_Text, {0.08f, 0.08f, 0.08f, 1});
    }
    const bool clicked = ImGui::Button(label, {width, 0});
    if (chosen)
        ImGui::PopStyleColor(4);
    return clicked;
}

void tip(const char* text) {
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", text);
}

} // namespace cmpg::viewer
