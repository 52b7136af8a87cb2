// Keys and gestures: one table for what they do and for the list of them.
#include "viewer/shortcuts.h"

#include "viewer/camera_control.h"
#include "viewer/theme.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>

namespace cmpg::viewer {
namespace {

enum Modifier { kNone, kCtrl, kCtrlShift };

struct Shortcut {
    int key;
    Modifier modifier;
    const char* keys; // as it is listed; null: with the one before
    const char* what;
    void (*perform)(Desk&);
};

void setMode(Desk& desk, LiveMode mode) {
    desk.session.change([mode](LiveSettings& s) { s.mode = mode; });
}

void exposeBy(Desk& desk, float stops) {
    desk.looks.settings.exposure = std::clamp(desk.looks.settings.exposure + stops, -20.f, 20.f);
}

void showActual(Desk& desk) {
    for (const LivePicture picture : {LivePicture::Image, LivePicture::Parameter})
        if (const auto& image = desk.state->picture(picture); image && desk.pictureArea)
            showActualSize(desk.viewOf(picture), image->width, image->height, *desk.pictureArea);
}

constexpr Shortcut kShortcuts[] = {
    {GLFW_KEY_1, kNone, "1  2  3", "render, gradient, optimise", [](Desk& d) { setMode(d, LiveMode::Render); }},
    {GLFW_KEY_2, kNone, nullptr, nullptr, [](Desk& d) { setMode(d, LiveMode::Gradient); }},
    {GLFW_KEY_3, kNone, nullptr, nullptr, [](Desk& d) { setMode(d, LiveMode::Optimize); }},
    {GLFW_KEY_SPACE, kNone, "Space", "run, pause", [](Desk& d) { d.session.change([](LiveSettings& s) { s.running = !s.running; }); }},
    {GLFW_KEY_N, kNone, "N", "one step (optimise, paused)",
     [](Desk& d) {
         if (d.state->settings.mode == LiveMode::Optimize && !d.state->settings.running)
             d.session.stepOnce();
     }},
    {GLFW_KEY_R, kNone, "R", "start again: values, steps and guide as at first", [](Desk& d) { d.session.reset(); }},
    {GLFW_KEY_T, kNone, "T", "one learning pass for the guide (render, gradient)",
     [](Desk& d) {
         if (d.state->settings.mode != LiveMode::Optimize)
             d.session.train();
     }},
    {GLFW_KEY_G, kNone, "G", "cells of the guide over the image",
     [](Desk& d) {
         d.cells = !d.cells;
         d.applyLayers();
     }},
    {GLFW_KEY_L, kNone, "L", "layers: normal, depth, albedo, guided share, cells",
     [](Desk& d) {
         d.layers = !d.layers;
         d.applyLayers();
     }},
    {GLFW_KEY_F, kNone, "F", "whole pictures", [](Desk& d) { d.views = {}; }},
    {GLFW_KEY_Z, kNone, "Z", "actual size, a pixel for a pixel", showActual},
    {GLFW_KEY_C, kNone, "C", "camera as in the file", [](Desk& d) { d.resetCamera(); }},
    {GLFW_KEY_LEFT_BRACKET, kNone, "[  ]", "exposure, by half a stop", [](Desk& d) { exposeBy(d, -0.5f); }},
    {GLFW_KEY_RIGHT_BRACKET, kNone, nullptr, nullptr, [](Desk& d) { exposeBy(d, 0.5f); }},
    {GLFW_KEY_S, kCtrl, "Ctrl+S", "save the picture or curve under the cursor as PNG", [](Desk& d) { d.saveMeant(Desk::As::Seen); }},
    {GLFW_KEY_E, kCtrl, "Ctrl+E", "save it as EXR (the curve: CSV), with its exact values", [](Desk& d) { d.saveMeant(Desk::As::Values); }},
    {GLFW_KEY_S, kCtrlShift, "Ctrl+Shift+S", "save the scene with the values recovered", [](Desk& d) { d.saveScene(); }},
    {GLFW_KEY_F1, kNone, "F1", "this list", [](Desk& d) { d.help = !d.help; }},
    {GLFW_KEY_ESCAPE, kNone, "Esc", "close what is open", [](Desk& d) { d.help = d.inspector = false; }},
    {GLFW_KEY_Q, kCtrl, "Ctrl+Q", "quit", [](Desk& d) { d.quit = true; }},
};

struct Gesture {
    const char* how;
    const char* what;
};

constexpr Gesture kGestures[] = {
    {"click", "look into the guide at that point of a surface"},
    {"left drag", "turn the camera; in optimise: move the pictures"},
    {"middle drag", "move the camera sideways"},
    {"right drag", "move the camera nearer or away; also Ctrl+wheel"},
    {"W A S D  Q E", "fly; faster with Shift"},
    {"wheel", "zoom all pictures about the cursor"},
    {"Shift+drag", "move all pictures"},
    {"drop a file", "open a scene (.gltf .glb .xml) or a target (.exr .hdr .png .jpg)"},
};

void followFlyKeys(std::vector<int>& keys, std::span<const KeyPress> pressed) {
    constexpr std::array kFlyKeys = {GLFW_KEY_W, GLFW_KEY_A, GLFW_KEY_S, GLFW_KEY_D, GLFW_KEY_Q, GLFW_KEY_E};
    for (const KeyPress& press : pressed)
        if (!press.control && std::find(kFlyKeys.begin(), kFlyKeys.end(), press.key) != kFlyKeys.end())
            keys.push_back(press.key);
    std::erase_if(keys, [](int key) { return !ImGui::IsKeyDown(key); });
}

bool fly(Desk& desk) {
    const ImGuiIO& io = ImGui::GetIO();
    if (!desk.camera() || !desk.state->scene || io.KeyCtrl || io.KeyAlt)
        return false;
    const auto down = [&](int key) { return std::find(desk.flyKeys.begin(), desk.flyKeys.end(), key) != desk.flyKeys.end(); };
    const auto held = [&](int plus, int minus) { return float(down(plus)) - float(down(minus)); };
    const glm::vec3 direction(held(GLFW_KEY_D, GLFW_KEY_A), held(GLFW_KEY_E, GLFW_KEY_Q), held(GLFW_KEY_W, GLFW_KEY_S));
    if (direction == glm::vec3(0))
        return false;
    const float size = glm::length(desk.state->scene->upper - desk.state->scene->lower);
    const float distance = size * std::min(io.DeltaTime, 0.1f) * (io.KeyShift ? 0.6f : 0.15f); // of the scene's box, a second
    desk.changeCamera([&](Camera& camera) { slide(camera, direction * distance); });
    return true;
}

} // namespace

bool handleKeys(Desk& desk, std::span<const KeyPress> pressed) {
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantTextInput) { // keys are of the text, but for the one that has none
        if (std::any_of(pressed.begin(), pressed.end(), [](const KeyPress& press) { return press.control && press.key == GLFW_KEY_Q; }))
            desk.quit = true;
        return false;
    }
    for (const KeyPress& press : pressed)
        for (const Shortcut& shortcut : kShortcuts)
            if (shortcut.key == press.key && shortcut.modifier == (press.control ? (press.shift ? kCtrlShift : kCtrl) : kNone))
                shortcut.perform(desk);
    followFlyKeys(desk.flyKeys, pressed);
    return fly(desk);
}

void drawHelp(Desk& desk) {
    if (!desk.help)
        return;
    const float font = ImGui::GetFontSize();
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::Begin("Keys and gestures", &desk.help, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    if (ImGui::BeginTable("keys", 2)) {
        ImGui::TableSetupColumn("how", ImGuiTableColumnFlags_WidthFixed, 8 * font);
        ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthFixed, 26 * font);
        const auto row = [](const char* how, const char* what) {
            ImGui::TableNextColumn();
            ImGui::TextColored(kAccent, "%s", how);
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(what);
        };
        for (const Gesture& gesture : kGestures)
            row(gesture.how, gesture.what);
        row("", "");
        for (const Shortcut& shortcut : kShortcuts)
            if (shortcut.keys)
                row(shortcut.keys, shortcut.what);
        ImGui::EndTable();
    }
    ImGui::End();
}

} // namespace cmpg::viewer
