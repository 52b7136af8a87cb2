// What the guide knows at the point that was clicked: maps of the sphere and figures.
#include "viewer/inspector.h"

#include "imaging/guide_maps.h"
#include "viewer/legend.h"
#include "viewer/picture_text.h"
#include "viewer/sphere_map.h"
#include "viewer/theme.h"
#include "viewer/widgets.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

constexpr float kDecades = 4; // of the maps' logarithmic colours, as in saved pictures of cells

constexpr const char* kNames[] = {"P: light", "D+: derivative, positive", "D\xe2\x88\x92: derivative, negative", "mixture for a camera path"};

double largest(const Image& map) {
    return map.values.empty() ? 0 : double(*std::max_element(map.values.begin(), map.values.end()));
}

void saveMaps(Desk& desk, const LivePick& pick) {
    desk.fileError.clear();
    try {
        const v1::GuidePoint& guide = *pick.guide;
        const std::filesystem::path file = desk.fileFor("cell-" + std::to_string(guide.cell), ".png");
        v1::saveImage(file, drawCell({.number = guide.cell,
                                      .weight = guide.weight,
                                      .means = guide.means,
                                      .weights = {guide.weights[0], guide.weights[1]},
                                      .density = [&](const std::array<double, 3>& mixture, int edge) { return guide.density(mixture, edge); }}));
        desk.saved = "wrote " + file.string();
    } catch (const Error& error) {
        desk.fail(error.what());
    }
}

void drawFigures(Desk& desk, const LivePick& pick) {
    figure("pixel", std::to_string(pick.x) + ", " + std::to_string(pick.y));
    figure("material", pick.material);
    if (desk.state->scene)
        figure("point", pointText(*desk.state->scene, pick.position));
    if (!pick.guide)
        return;
    char text[96];
    figure("cell", std::to_string(pick.guide->cell) + " of " + std::to_string(pick.guide->cells));
    figure("records", shortNumber(pick.guide->records));
    std::snprintf(text, sizeof text, "%.0f %%", 100 * pick.guide->guideShare);
    figure("guide draws", text);
    std::snprintf(text, sizeof text, "%.0f %% P, %.0f %% D", 100 * pick.guide->lightShare, 100 * (1 - pick.guide->lightShare));
    figure("mixture", text);
    if (ImGui::Button("Save the maps as PNG", {-1, 0}))
        saveMaps(desk, pick);
}

void drawMap(Desk& desk, int index, const std::shared_ptr<const Image>& map, const Rectangle& tile, std::vector<PanelQuad>& quads) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = ImGui::GetFontSize(), caption = std::round(1.3f * font);
    const float edge = std::floor(std::min(tile.width, tile.height - caption));
    if (edge < 2 * font)
        return;
    draw.AddText({tile.x, tile.y}, packed(index == 3 ? kAccent : kInk), kNames[index]);
    PanelQuad quad;
    quad.place = quad.clip = {tile.x, tile.y + caption, edge, edge};
    quad.kind = gpu::kPanelPlain;
    quad.background = {0.085f, 0.085f, 0.09f, 1};
    const double high = map ? largest(*map) : 0;
    if (high > 0) {
        quad.image = map;
        quad.kind = gpu::kPanelLogarithmic;
        quad.factor = float(1 / high);
        quad.decades = kDecades;
    } else {
        draw.AddText({tile.x + 0.6f * font, tile.y + caption + 0.5f * (edge - font)}, packed(kDim), "nothing known");
    }
    quads.push_back(quad);
    // Beside the map, where there is room: its range, and the axes.
    const float beside = tile.x + edge + 0.5f * font;
    if (tile.right() - beside > 5 * font) {
        draw.AddText({beside, quad.place.y}, packed(kDim), "z = 1");
        draw.AddText({beside, quad.place.bottom() - font}, packed(kDim), "z = \xe2\x88\x92" "1");
        if (high > 0) {
            draw.AddText({beside, quad.place.y + 0.5f * edge - 1.2f * font}, packed(kDim), "highest");
            draw.AddText({beside, quad.place.y + 0.5f * edge}, packed(kInk), shortNumber(high).c_str());
        }
    }
    ImGui::SetCursorScreenPos({quad.place.x, quad.place.y});
    ImGui::PushID(index);
    ImGui::InvisibleButton("map", {edge, edge});
    ImGui::PopID();
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (ImGui::IsItemHovered()) {
        const glm::vec2 place((mouse.x - quad.place.x) / edge, (mouse.y - quad.place.y) / edge);
        desk.directionFound = directionAt(glm::clamp(place, 0.f, 1.f));
        if (map) {
            const auto pixel = glm::min(glm::ivec2(place * glm::vec2(map->width, map->height)), glm::ivec2(map->width - 1, map->height - 1));
            ImGui::SetTooltip("%s x uniform", shortNumber(double(*map->at(std::max(0, pixel.x), std::max(0, pixel.y)))).c_str());
        }
    }
    const auto mark = [&](glm::vec3 direction, const ImVec4& color) {
        const glm::vec2 place = placeOfDirection(direction);
        const ImVec2 at(quad.place.x + place.x * edge, quad.place.y + place.y * edge);
        draw.AddCircle(at, 0.35f * font + 1, packed({0, 0, 0, 0.8f}), 0, 2);
        draw.AddCircle(at, 0.35f * font, packed(color), 0, 1.5f);
    };
    if (desk.direction)
        mark(*desk.direction, {1, 1, 1, 1});
}

} // namespace

float inspectorWidth(const Desk& desk, const Rectangle& area) {
    return desk.inspector && desk.state->pick ? std::round(std::min(0.45f * area.width, 18 * ImGui::GetFontSize())) : 0;
}

void drawInspector(Desk& desk, const Rectangle& area, std::vector<PanelQuad>& quads) {
    const auto& pick = desk.state->pick;
    if (!desk.inspector || !pick)
        return;
    desk.directionFound.reset();
    ImGui::SetNextWindowPos({area.x, area.y});
    ImGui::SetNextWindowSize({area.width, area.height});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    ImGui::Begin("inspector", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBackground |
                                           ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    ImGui::TextColored(kAccent, "The guide at this point");
    ImGui::SameLine(area.width - 4 * ImGui::GetFontSize());
    if (ImGui::SmallButton("Close"))
        desk.inspector = false;
    if (!pick->hit) {
        ImGui::TextColored(kDim, "There is no surface at this pixel.");
    } else {
        drawFigures(desk, *pick);
        if (!pick->guide) {
            ImGui::PushTextWrapPos(0);
            ImGui::TextColored(kDim, "The guide knows nothing yet. Press T for a learning pass, or run an optimisation.");
            ImGui::PopTextWrapPos();
        } else {
            ImGui::PushTextWrapPos(0);
            ImGui::TextColored(kDim, "All directions: azimuth across, z up. Brighter: drawn more often. Point at one to see where it leads.");
            ImGui::PopTextWrapPos();
            const float top = ImGui::GetCursorScreenPos().y + 4, gap = std::round(0.5f * ImGui::GetFontSize());
            const float height = (area.bottom() - top - 3 * gap) / 4;
            for (int i = 0; i < 4; ++i)
                drawMap(desk, i, pick->maps[std::size_t(i)], {area.x, std::round(top + float(i) * (height + gap)), area.width, height}, quads);
        }
    }
    ImGui::End();
    ImGui::PopStyleVar();
    desk.direction = desk.directionFound;
}

} // namespace cmpg::viewer
