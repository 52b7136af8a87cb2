// What is written beside a picture.
#include "viewer/picture_text.h"

#include "viewer/legend.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

std::string samplesText(std::uint32_t samples) {
    return std::to_string(samples) + (samples == 1 ? " sample" : " samples");
}

std::string firstName(const LiveState& state) {
    const v1::ParameterInfo* const item = shownParameter(state);
    return item ? item->name : "no parameter";
}

std::string sizeText(const LiveState& state) {
    const v1::ParameterInfo* const item = shownParameter(state);
    return item ? std::to_string(item->width) + " x " + std::to_string(item->height) : "";
}

} // namespace

std::string pointText(const LiveScene& scene, glm::vec3 position) {
    const double size = glm::length(glm::dvec3(scene.upper) - glm::dvec3(scene.lower));
    const int decimals = std::clamp(3 - int(std::floor(std::log10(std::max(size, 1e-9)))), 0, 9);
    const glm::dvec3 point = scene.center + glm::dvec3(position);
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
        char number[64];
        std::snprintf(number, sizeof number, "%.*f", decimals, point[axis]);
        text += (axis ? "  " : "") + std::string(number);
    }
    return text;
}

std::string parametersText(const LiveState& state) {
    const std::size_t count = state.settings.parameters.size();
    return firstName(state) + (count > 1 ? " and " + std::to_string(count - 1) + " more" : "");
}

std::string windowTitle(const LiveState& state, const std::string& scene) {
    std::string text = scene + " - ";
    if (state.settings.mode == LiveMode::Optimize)
        text += "optimise, step " + std::to_string(state.step);
    else if (state.settings.mode == LiveMode::Gradient)
        text += "gradient, " + samplesText(state.gradientSamples);
    else
        text += "render, " + samplesText(state.imageSamples);
    if (!state.notice.empty())
        text += ", " + state.notice;
    else if (!state.refining)
        text += ", at rest";
    return text + " - cmpg-vk";
}

std::string titleOf(const LiveState& state, LivePicture picture) {
    switch (picture) {
    case LivePicture::Difference: return "image \xe2\x88\x92 target";
    case LivePicture::Gradient: return "\xe2\x88\x82 image / \xe2\x88\x82 " + parametersText(state);
    case LivePicture::Parameter: return firstName(state);
    case LivePicture::ParameterGradient: return "\xe2\x88\x82 loss / \xe2\x88\x82 " + firstName(state);
    case LivePicture::Guided: return "guided share";
    case LivePicture::Cells: return "cells of the guide";
    default: return livePictureName(picture);
    }
}

std::string detailOf(const LiveState& state, LivePicture picture) {
    if (!state.picture(picture))
        return "";
    switch (picture) {
    case LivePicture::Image: return state.imageCarried ? "of the last steps" : samplesText(state.imageSamples);
    case LivePicture::Target:
        return state.settings.view < state.targets.size() ? std::filesystem::path(state.targets[state.settings.view]).filename().string() : "";
    case LivePicture::Gradient: return state.gradientFading ? "of the last steps" : samplesText(state.gradientSamples);
    case LivePicture::Parameter: return sizeText(state);
    case LivePicture::ParameterGradient: return state.step > 0 ? "step " + std::to_string(state.step) : "";
    case LivePicture::Normal: return "world space";
    case LivePicture::Depth: return "along the ray";
    case LivePicture::Guided: return "of the first directions";
    case LivePicture::Cells: return state.guideCells > 0 ? std::to_string(state.guideCells) + " in all" : "";
    default: return "";
    }
}

std::string emptyText(const LiveState& state, LivePicture picture) {
    const bool needsTarget = picture == LivePicture::Target || picture == LivePicture::Difference || picture == LivePicture::ParameterGradient;
    if (needsTarget && state.settings.mode == LiveMode::Optimize && state.views == 0)
        return "no target";
    if (picture == LivePicture::Gradient && state.settings.parameters.empty())
        return "select a parameter";
    if (picture == LivePicture::ParameterGradient && state.step == 0)
        return "after the first step";
    if ((picture == LivePicture::Cells || picture == LivePicture::Guided) && !state.guideLearned)
        return "the guide knows nothing yet";
    return state.dead ? "" : "not yet";
}

std::string valueText(const Image& image, glm::ivec2 pixel, LivePicture picture) {
    if (pixel.x >= image.width || pixel.y >= image.height)
        return "";
    const float* const value = image.at(pixel.x, pixel.y);
    if (picture == LivePicture::Cells)
        return value[0] < 0 ? "no cell" : "cell " + std::to_string(std::lround(value[0]));
    std::string text;
    for (int c = 0; c < image.channels; ++c)
        text += (c ? "  " : "") + shortNumber(double(value[c]));
    return text;
}

} // namespace cmpg::viewer
