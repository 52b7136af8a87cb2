// The pictures: captions, values under the cursor, legends, and what the mouse does in them.
#include "viewer/panels.h"

#include "viewer/camera_control.h"
#include "viewer/guide_arrow.h"
#include "viewer/legend.h"
#include "viewer/loss_plot.h"
#include "viewer/picture_text.h"
#include "viewer/theme.h"
#include "viewer/widgets.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

constexpr float kClick = 4; // pixels the mouse may move in a click

void dragCamera(Desk& desk, glm::vec2 moved, float height, ImGuiMouseButton button) {
    desk.changeCamera([&](Camera& camera) {
        const glm::vec3 pivot = desk.pivotOf(camera);
        const glm::vec2 share = moved / height; // of the panel's height
        if (button == ImGuiMouseButton_Left) {
            constexpr float kTurn = 3; // radians for a drag over the whole height
            orbit(camera, pivot, -share.x * kTurn, -share.y * kTurn);
        } else if (button == ImGuiMouseButton_Middle) {
            // The point ahead stays under the cursor.
            const float ahead = std::max(1e-4f, glm::dot(pivot - eyeOf(camera), forwardOf(camera)));
            const float seen = camera.orthographic ? 2 * camera.ymag : 2 * ahead * std::tan(0.5f * camera.yfov);
            slide(camera, {-share.x * seen, share.y * seen, 0});
        } else {
            approach(camera, pivot, std::exp(2 * share.y));
        }
    });
}

// What the mouse does over a panel.
void handleMouse(Desk& desk, LivePicture picture, const Image& image, const Rectangle& area, const Rectangle& place) {
    const ImGuiIO& io = ImGui::GetIO();
    const glm::vec2 mouse(io.MousePos.x, io.MousePos.y), moved(io.MouseDelta.x, io.MouseDelta.y);
    PictureView& view = desk.viewOf(picture);
    const bool turns = desk.camera() && groupOf(picture) == Group::Image;
    if (ImGui::IsItemHovered()) {
        if (const auto pixel = pixelAt(mouse, image.width, image.height, place))
            desk.hoverFound = Hover{picture, *pixel};
        if (io.MouseWheel != 0) {
            if (io.KeyCtrl && turns)
                desk.changeCamera([&](Camera& camera) { approach(camera, desk.pivotOf(camera), std::pow(0.9f, io.MouseWheel)); });
            else
                zoomAbout(view, std::pow(1.2, double(io.MouseWheel)), mouse, image.width, image.height, area);
        }
    }
    for (const ImGuiMouseButton button : {ImGuiMouseButton_Left, ImGuiMouseButton_Middle, ImGuiMouseButton_Right}) {
        if (!ImGui::IsItemActive() || !ImGui::IsMouseDragging(button, kClick))
            continue;
        if (turns && !io.KeyShift)
            dragCamera(desk, moved, std::max(1.f, area.height), button);
        else
            panBy(view, moved, image.width, image.height, area);
    }
    const bool clicked = ImGui::IsItemDeactivated() && ImGui::IsMouseReleased(ImGuiMouseButton_Left) &&
                         io.MouseDragMaxDistanceSqr[ImGuiMouseButton_Left] < kClick * kClick;
    if (clicked && groupOf(picture) == Group::Image)
        if (const auto pixel = pixelAt({io.MouseClickedPos[0].x, io.MouseClickedPos[0].y}, image.width, image.height, place))
            desk.pick(*pixel, image);
}

// Frames a pixel, at least so large that it can be seen.
void markPixel(glm::ivec2 pixel, const Image& image, const Rectangle& place, ImU32 color) {
    const float scale = place.width / float(image.width), half = std::max(0.5f * scale, 3.f);
    const ImVec2 middle(place.x + (float(pixel.x) + 0.5f) * scale, place.y + (float(pixel.y) + 0.5f) * scale);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddRect({middle.x - half - 1, middle.y - half - 1}, {middle.x + half + 1, middle.y + half + 1}, packed({0, 0, 0, 0.7f}));
    draw.AddRect({middle.x - half, middle.y - half}, {middle.x + half, middle.y + half}, color);
}

void drawMarks(const Desk& desk, LivePicture picture, const Image& image, const Rectangle& area, const Rectangle& place) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.PushClipRect({area.x, area.y}, {area.right(), area.bottom()}, true);
    if (desk.hover && groupOf(desk.hover->picture) == groupOf(picture) && desk.hover->picture != picture)
        if (desk.hover->pixel.x < image.width && desk.hover->pixel.y < image.height)
            markPixel(desk.hover->pixel, image, place, packed({1, 1, 1, 0.9f}));
    if (groupOf(picture) == Group::Image)
        drawGuideArrow(desk, place);
    draw.PopClipRect();
}

void drawCaption(const Desk& desk, LivePicture picture, const Rectangle& tile) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const LiveState& state = *desk.state;
    std::string value;
    if (const auto& image = state.picture(picture); image && desk.hover && groupOf(desk.hover->picture) == groupOf(picture))
        value = valueText(*image, desk.hover->pixel, picture);
    const float gap = 0.8f * ImGui::GetFontSize();
    const float valueWidth = value.empty() ? 0 : ImGui::CalcTextSize(value.c_str()).x;
    const std::string title = shortened(titleOf(state, picture), tile.width - valueWidth - gap);
    draw.AddText({tile.x, tile.y}, packed(kInk), title.c_str());
    const float titleWidth = ImGui::CalcTextSize(title.c_str()).x;
    const std::string detail = detailOf(state, picture);
    if (ImGui::CalcTextSize(detail.c_str()).x <= tile.width - titleWidth - valueWidth - 2 * gap)
        draw.AddText({tile.x + titleWidth + gap, tile.y}, packed(kDim), detail.c_str());
    draw.AddText({tile.right() - valueWidth, tile.y}, packed(kAccent), value.c_str());
}

void drawPanel(Desk& desk, LivePicture picture, const Rectangle& tile, std::vector<PanelQuad>& quads) {
    const float caption = std::round(1.35f * ImGui::GetFontSize());
    const PictureLook look = desk.looks.of(*desk.state, picture);
    const Rectangle area{tile.x, tile.y + caption, tile.width, std::max(1.f, tile.height - caption - legendHeight())};
    drawCaption(desk, picture, tile);
    PanelQuad ground;
    ground.place = ground.clip = area;
    ground.kind = gpu::kPanelPlain;
    ground.background = {0.085f, 0.085f, 0.09f, 1};
    quads.push_back(ground);
    const auto& image = desk.state->picture(picture);
    if (!image || image->width == 0 || image->height == 0) {
        const std::string reason = shortened(emptyText(*desk.state, picture), area.width - 8);
        const ImVec2 size = ImGui::CalcTextSize(reason.c_str());
        ImGui::GetWindowDrawList()->AddText({std::round(area.x + 0.5f * (area.width - size.x)), std::round(area.y + 0.5f * (area.height - size.y))},
                                            packed(kDim), reason.c_str());
        return;
    }
    if (picture == LivePicture::Image)
        desk.pictureArea = area;
    const Rectangle place = placeOf(desk.viewOf(picture), image->width, image->height, area);
    ImGui::SetCursorScreenPos({area.x, area.y});
    ImGui::PushID(int(picture));
    ImGui::InvisibleButton("panel", {area.width, area.height},
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonMiddle | ImGuiButtonFlags_MouseButtonRight);
    handleMouse(desk, picture, *image, area, place);
    ImGui::PopID();
    PanelQuad quad;
    quad.image = image;
    quad.place = place;
    quad.clip = area;
    quad.kind = look.kind;
    quad.factor = look.factor;
    quads.push_back(quad);
    const auto& cells = desk.state->picture(LivePicture::Cells);
    if (desk.cells && cells && picture == LivePicture::Image && cells->width == image->width) {
        quad.image = cells;
        quad.kind = gpu::kPanelCells;
        quad.opacity = 0.4f;
        quads.push_back(quad);
    }
    drawMarks(desk, picture, *image, area, place);
    drawLegend(look, {tile.x, std::clamp(place.bottom(), area.y, area.bottom()), tile.width, legendHeight()});
}

} // namespace

void drawPanels(Desk& desk, const Rectangle& area, std::vector<PanelQuad>& quads) {
    const float font = ImGui::GetFontSize();
    const std::vector<LivePicture> pictures = picturesOf(desk.state->settings.mode, desk.layers);
    desk.looks.update(*desk.state, pictures);
    Rectangle space = area;
    const bool plot = desk.state->settings.mode == LiveMode::Optimize;
    const float plotHeight = std::round(std::clamp(0.16f * area.height + 1.3f * font, 5 * font, 11 * font));
    if (plot)
        space.height -= plotHeight + 0.6f * font;
    float aspect = 1;
    if (const auto& image = desk.state->picture(LivePicture::Image); image && image->height > 0)
        aspect = float(image->width) / float(image->height);
    const float border = std::round(1.35f * font) + legendHeight();
    desk.pictureArea.reset();
    desk.hoverFound.reset();
    desk.overLoss = false;
    const std::vector<Rectangle> places = tiles(space, pictures.size(), aspect, border, std::round(0.6f * font));
    for (std::size_t i = 0; i < pictures.size(); ++i)
        drawPanel(desk, pictures[i], places[i], quads);
    desk.hover = desk.hoverFound;
    if (plot) {
        const std::span<const double> loss = desk.state->loss ? std::span<const double>(*desk.state->loss) : std::span<const double>();
        const Rectangle place{area.x, space.bottom() + 0.6f * font, area.width, plotHeight};
        drawLossPlot(place, loss);
        desk.overLoss = !loss.empty() && ImGui::IsWindowHovered() && ImGui::IsMouseHoveringRect({place.x, place.y}, {place.right(), place.bottom()});
    }
}

} // namespace cmpg::viewer
