// The window: joins the work, the interface and the presentation, and runs until it is closed.
#include "viewer/viewer.h"

#include "session/interrupt.h"
#include "viewer/controls.h"
#include "viewer/inspector.h"
#include "viewer/panels.h"
#include "viewer/picture_text.h"
#include "viewer/present/presenter.h"
#include "viewer/shortcuts.h"
#include "viewer/status_line.h"
#include "viewer/theme.h"
#include "viewer/window.h"

#include <backends/imgui_impl_glfw.h>
#include <cmath>

namespace cmpg::viewer {
namespace {

constexpr int kWidth = 1440, kHeight = 900;

// Dear ImGui with the display's events.
struct Interface {
    explicit Interface(Window& window) {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr; // leaves no file behind
        applyTheme(window.scale());
        ImGui_ImplGlfw_InitForVulkan(window.handle(), true);
    }
    ~Interface() {
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    Interface(const Interface&) = delete;
};

// Builds one frame of the interface. True: the next should follow at once.
bool buildFrame(Desk& desk, std::span<const KeyPress> keys, std::vector<PanelQuad>& quads) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const bool keysHeld = handleKeys(desk, keys);
    const float controls = std::min(controlsWidth(), 0.5f * size.x), margin = std::round(0.8f * ImGui::GetFontSize());
    drawControls(desk, {0, 0, controls, size.y});

    Rectangle area{controls + margin, margin, std::max(1.f, size.x - controls - 2 * margin), std::max(1.f, size.y - margin - statusHeight())};
    const Rectangle status{area.x, area.bottom(), area.width, statusHeight()};
    if (const float column = inspectorWidth(desk, area); column > 0) {
        area.width = std::max(1.f, area.width - column - margin);
        drawInspector(desk, {area.right() + margin, area.y, column, area.height}, quads);
    }
    ImGui::SetNextWindowPos({controls, 0});
    ImGui::SetNextWindowSize({status.right() + margin - controls, size.y});
    ImGui::Begin("pictures", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBackground |
                                          ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                                          ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoNav);
    drawPanels(desk, area, quads);
    drawStatusLine(desk, status);
    drawNotice(desk, area);
    ImGui::End();
    drawHelp(desk);
    return keysHeld;
}

// From the interface's units to pixels of the framebuffer, which are others on some displays.
void scaleToPixels(std::vector<PanelQuad>& quads) {
    const ImVec2 scale = ImGui::GetIO().DisplayFramebufferScale;
    for (PanelQuad& quad : quads)
        for (Rectangle* r : {&quad.place, &quad.clip})
            *r = {r->x * scale.x, r->y * scale.y, r->width * scale.x, r->height * scale.y};
}

} // namespace

ExitStatus runViewer(const Options& options) {
    const std::atomic<bool>& interrupted = stopOnInterrupt();
    Window window("cmpg-vk", kWidth, kHeight);
    Interface interface(window);
    Presenter presenter(window.handle(), options.device);
    LiveSession session(options, &Window::wake); // the last made, and so the first to end: it wakes the window until then
    Desk desk(session);
    if (!options.output.empty())
        desk.folder = options.output;

    float scale = window.scale();
    std::uint64_t shown = ~std::uint64_t(0);
    std::vector<PanelQuad> quads;
    constexpr double kIdle = 0.25, kBusy = 0.05; // seconds: looks at Ctrl-C and blinking cursors; turns the sign of work
    bool hidden = false; // minimised, or without area: nothing can be drawn, whatever happens
    while (!window.closing() && !desk.quit && !interrupted) {
        const double patience = desk.state->busy ? kBusy : kIdle;
        window.wait(window.framesDue() && !hidden ? 0 : patience);
        desk.update();
        window.setTitle(windowTitle(*desk.state, desk.sceneName()));
        for (const auto& files : window.takeDropped())
            desk.open(files);
        if (desk.state->version != shown || desk.state->busy)
            window.requestFrames(1);
        if (ImGui::GetIO().WantTextInput)
            window.requestFrames(1);
        hidden = window.minimised();
        if (hidden || !window.takeFrame())
            continue;
        if (window.scale() != scale) {
            scale = window.scale();
            applyTheme(scale);
            presenter.fontsChanged();
        }
        hidden = !presenter.begin();
        if (hidden)
            continue;
        shown = desk.state->version;
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        quads.clear();
        if (buildFrame(desk, window.takeKeys(), quads))
            window.requestFrames(1);
        ImGui::Render();
        scaleToPixels(quads);
        presenter.end(quads);
    }
    return interrupted ? ExitStatus::Interrupted : ExitStatus::Done;
}

} // namespace cmpg::viewer
