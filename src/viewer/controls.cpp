// The panel on the left: everything that can be set, and the figures of the work.
#include "viewer/controls.h"

#include "viewer/legend.h"
#include "viewer/theme.h"
#include "viewer/widgets.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

using Edit = std::function<void(LiveSettings&)>;

void drawMode(Desk& desk) {
    const LiveMode mode = desk.state->settings.mode;
    const std::pair<const char*, LiveMode> modes[] = {{"Render", LiveMode::Render}, {"Gradient", LiveMode::Gradient}, {"Optimise", LiveMode::Optimize}};
    const char* const names[] = {modes[0].first, modes[1].first, modes[2].first};
    const std::vector<float> widths = widthsOfButtons(names);
    for (std::size_t i = 0; i < widths.size(); ++i) {
        if (i > 0)
            ImGui::SameLine();
        if (choiceButton(modes[i].first, modes[i].second == mode, widths[i]))
            desk.session.change([v = modes[i].second](LiveSettings& s) { s.mode = v; });
    }
}

void drawRun(Desk& desk) {
    const bool running = desk.session.settings().running, optimizes = desk.state->settings.mode == LiveMode::Optimize;
    const float width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
    if (ImGui::Button(running ? "Pause" : "Run", {width, 0}))
        desk.session.change([&](LiveSettings& s) { s.running = !running; });
    ImGui::SameLine();
    ImGui::BeginDisabled(running || !optimizes);
    if (ImGui::Button("Step", {width, 0}))
        desk.session.stepOnce();
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::Button("Reset", {width, 0}))
        desk.session.reset();
    tip("Values, steps and guide as at first");
}

// The scene's name and, beside it, what is amiss in its file: nothing below moves by that.
void drawScene(const Desk& desk) {
    const std::string name = desk.sceneName();
    const std::size_t count = desk.state->scene ? desk.state->scene->warnings.size() : 0;
    if (count == 0) {
        ImGui::TextUnformatted(shortened(name, ImGui::GetContentRegionAvail().x).c_str());
        return;
    }
    const std::string label = std::to_string(count) + (count == 1 ? " warning" : " warnings");
    const ImGuiStyle& style = ImGui::GetStyle();
    const float right = ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x;
    const float width = ImGui::CalcTextSize(label.c_str()).x + 2 * style.FramePadding.x;
    ImGui::TextUnformatted(shortened(name, ImGui::GetContentRegionAvail().x - width - style.ItemSpacing.x).c_str());
    ImGui::SameLine(right - width);
    ImGui::PushStyleColor(ImGuiCol_Text, kAccent);
    if (ImGui::SmallButton((label + "###warnings").c_str()))
        ImGui::OpenPopup("warnings");
    ImGui::PopStyleColor();
    const auto list = [&] {
        ImGui::PushTextWrapPos(std::min(30 * ImGui::GetFontSize(), 0.8f * ImGui::GetIO().DisplaySize.x));
        for (const std::string& warning : desk.state->scene->warnings)
            ImGui::TextUnformatted(warning.c_str());
        ImGui::PopTextWrapPos();
    };
    if (ImGui::IsItemHovered() && !ImGui::IsPopupOpen("warnings")) {
        ImGui::BeginTooltip();
        list();
        ImGui::EndTooltip();
    }
    if (ImGui::BeginPopup("warnings")) {
        list();
        ImGui::EndPopup();
    }
}

void drawError(Desk& desk) {
    const LiveError* const error = desk.openError();
    if (!error && desk.fileError.empty())
        return;
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(kAlarm, "%s", error ? error->what.c_str() : desk.fileError.c_str());
    if (error && !error->cause.empty())
        ImGui::TextColored(kDim, "Cause: %s", error->cause.c_str());
    if (error && !error->remedy.empty())
        ImGui::TextColored(kDim, "Remedy: %s", error->remedy.c_str());
    ImGui::PopTextWrapPos();
    if (ImGui::SmallButton("Dismiss"))
        desk.closeError();
    ImGui::Spacing();
}

void drawFigures(const Desk& desk) {
    const LiveState& state = *desk.state;
    if (state.settings.mode != LiveMode::Optimize) {
        figure("samples", std::to_string(state.imageSamples) + (state.refining ? "" : ", at rest"));
        if (state.settings.mode == LiveMode::Gradient)
            figure("of the gradient", std::to_string(state.gradientSamples));
        return;
    }
    const auto duration = [](double seconds) {
        char text[32];
        std::snprintf(text, sizeof text, seconds < 0.9995 ? "%.0f ms" : "%.1f s", seconds < 0.9995 ? seconds * 1e3 : seconds);
        return std::string(text);
    };
    figure("step", std::to_string(state.step));
    figure("loss", state.loss && !state.loss->empty() ? shortNumber(state.loss->back()) : "");
    figure("image, gradient", state.step ? duration(state.secondsPrimal) + ", " + duration(state.secondsGradient) : "");
    figure("update", state.step ? duration(state.secondsUpdate) : "");
}

// The first selected is the one whose texture is shown, so the order of selection is kept.
void select(Desk& desk, std::uint32_t parameter, bool on) {
    desk.session.change([&](LiveSettings& s) {
        std::erase(s.parameters, parameter);
        if (on)
            s.parameters.push_back(parameter);
    });
}

void drawParameters(Desk& desk, std::size_t most) {
    if (!desk.state->scene)
        return;
    const auto& items = desk.state->scene->parameters;
    constexpr std::size_t kMany = 8;
    if (items.size() > kMany) {
        char wanted[64];
        std::snprintf(wanted, sizeof wanted, "%s", desk.wanted.c_str());
        ImGui::SetNextItemWidth(-1);
        ImGui::PushID(int(desk.wantedOf)); // a field that is being typed in would bring the text of the scene before back
        if (ImGui::InputTextWithHint("##find", "part of a name", wanted, sizeof wanted))
            desk.wanted = wanted;
        ImGui::PopID();
    }
    const std::vector<std::uint32_t> selected = desk.session.settings().parameters;
    const float row = ImGui::GetFrameHeight() + 2;
    ImGui::BeginChild("parameters", {0, row * float(std::clamp<std::size_t>(items.size(), 2, most)) + 8}, true);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {ImGui::GetStyle().ItemSpacing.x, 2});
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        if (items[i].name.find(desk.wanted) == std::string::npos)
            continue;
        bool on = std::find(selected.begin(), selected.end(), i) != selected.end();
        // The name goes before the size, where there is no room for both.
        const float room = ImGui::GetContentRegionAvail().x - ImGui::GetFrameHeight() - ImGui::GetStyle().ItemInnerSpacing.x;
        const std::string name = shortened(items[i].name, room);
        const std::string size = items[i].textured ? std::to_string(items[i].width) + " x " + std::to_string(items[i].height) : "";
        const float sizeWidth = ImGui::CalcTextSize(size.c_str()).x;
        const bool both = ImGui::CalcTextSize(name.c_str()).x + ImGui::GetStyle().ItemSpacing.x + sizeWidth <= room;
        if (ImGui::Checkbox((name + "###" + items[i].name).c_str(), &on))
            select(desk, i, on);
        if (name != items[i].name || !both)
            tip((items[i].name + (size.empty() ? "" : "   " + size)).c_str());
        if (!size.empty() && both) {
            ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - sizeWidth);
            ImGui::TextDisabled("%s", size.c_str());
        }
    }
    ImGui::PopStyleVar();
    ImGui::EndChild();
}

void drawSampling(Desk& desk) {
    const LiveState& state = *desk.state;
    const Sampling wanted = desk.session.settings().sampling;
    if (beginField("sampling", nameOf(wanted, kSamplings)) && ImGui::BeginCombo("##sampling", nameOf(wanted, kSamplings))) {
        for (const auto& choice : kSamplings)
            if (ImGui::Selectable(choice.name, choice.value == wanted))
                desk.session.change([v = choice.value](LiveSettings& s) { s.sampling = v; });
        ImGui::EndCombo();
    }
    tip("Where directions are drawn from: the materials (bsdf), the light that was found (primal),\nits derivatives (differential), "
        "or both (uniform, conditional). auto takes what is measured to be best.");
    char share[32];
    std::snprintf(share, sizeof share, "%.0f %% of directions", 100 * state.guidedShare);
    figure("in use", std::string(nameOf(state.sampling, kSamplings)) + (state.roulette ? ", roulette" : ""));
    figure("guided", share);
    figure("learned from", std::to_string(state.guidePasses) + (state.guidePasses == 1 ? " pass, " : " passes, ") + std::to_string(state.guideCells) + " cells");
    if (state.settings.mode != LiveMode::Optimize) {
        if (ImGui::Button("Learn a pass", {-1, 0}))
            desk.session.train();
        tip("The guide learns where light and its derivatives come from. An optimisation teaches it by itself.");
    }
}

void drawOptimization(Desk& desk) {
    const LiveSettings wished = desk.session.settings();
    float factor = wished.rateFactor;
    if (beginField("rate") && ImGui::SliderFloat("##rate", &factor, 0.05f, 20.f, "x %.2f", ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
        desk.session.change([&](LiveSettings& s) { s.rateFactor = factor; });
    tip("On the learning rates of all parameters, while it runs");
    int spp = int(wished.spp), sppGradient = int(wished.sppGradient);
    if (beginField("image samples") && ImGui::SliderInt("##spp", &spp, 1, 256, "%d", ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
        desk.session.change([&](LiveSettings& s) { s.spp = std::uint32_t(spp); });
    if (beginField("gradient samples") && ImGui::SliderInt("##sppg", &sppGradient, 1, 256, "%d", ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
        desk.session.change([&](LiveSettings& s) { s.sppGradient = std::uint32_t(sppGradient); });
    if (desk.state->views > 1) {
        int view = int(wished.view);
        if (beginField("target shown") && ImGui::SliderInt("##view", &view, 0, int(desk.state->views) - 1))
            desk.session.change([&](LiveSettings& s) { s.view = std::uint32_t(view); });
    }
    const char* const kStart = "Start from grey";
    const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
    if (button(kStart, std::max(half, ImGui::CalcTextSize(kStart).x + 4)))
        desk.session.fill(desk.fill);
    tip("All entries of the selected parameters become this grey; the steps then find what the target shows");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderFloat("##fill", &desk.fill, 0, 1, "%.2f");
    if (button("Take the image as target", ImGui::GetContentRegionAvail().x))
        desk.session.useImageAsTarget();
}

void drawCamera(Desk& desk) {
    if (!desk.state->scene)
        return;
    const LiveSettings wished = desk.session.settings();
    if (beginField("camera", wished.camera.name) && ImGui::BeginCombo("##camera", wished.camera.name.c_str())) {
        for (const Camera& camera : desk.state->scene->cameras)
            if (ImGui::Selectable(camera.name.c_str(), camera.name == wished.camera.name))
                desk.changeCamera([&](Camera& c) { c = camera; });
        ImGui::EndCombo();
    }
    const std::string size = std::to_string(wished.width) + " x " + std::to_string(wished.height);
    if (beginField("size", size) && ImGui::BeginCombo("##size", size.c_str())) {
        for (const int width : {128, 192, 256, 384, 512, 768, 1024, 1536, 2048})
            if (ImGui::Selectable((std::to_string(width) + " wide").c_str(), width == wished.width))
                desk.session.change([&](LiveSettings& s) {
                    s.height = std::max(1, int(std::lround(double(s.height) * width / s.width)));
                    s.width = width;
                });
        ImGui::EndCombo();
    }
}

void drawLook(Desk& desk) {
    LookSettings& look = desk.looks.settings;
    if (beginField("exposure"))
        ImGui::SliderFloat("##exposure", &look.exposure, -10, 10, "%+.1f stops");
    const char* const rules[] = {"automatic", "shared", "fixed"};
    int rule = int(look.rule);
    if (beginField("signed scale", rules[rule]) && ImGui::Combo("##rule", &rule, rules, 3))
        look.rule = ScaleRule(rule);
    tip("The value of the deepest blue and orange: of each picture by itself (99.5 % of its pixels lie within),\nthe largest of these for all, "
        "or one that you set");
    if (look.rule == ScaleRule::Fixed && beginField("scale"))
        ImGui::DragFloat("##scale", &look.fixedScale, 0.01f * look.fixedScale, 1e-9f, 1e9f, "%.3g");
    if (ImGui::Checkbox("Layers", &desk.layers))
        desk.applyLayers();
    tip("Panels of normal, depth, albedo, guided share and cells");
    const char* const kCells = "Cells of the guide";
    ImGui::SameLine();
    if (ImGui::GetContentRegionAvail().x < ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x + ImGui::CalcTextSize(kCells).x)
        ImGui::NewLine();
    if (ImGui::Checkbox(kCells, &desk.cells))
        desk.applyLayers();
    tip("Over the image");
}

void drawSave(Desk& desk) {
    char folder[512];
    std::snprintf(folder, sizeof folder, "%s", desk.folder.c_str());
    if (beginField("folder") && ImGui::InputText("##folder", folder, sizeof folder))
        desk.folder = folder;
    const char* const labels[] = {"Picture (PNG)", "Values (EXR)"};
    const std::vector<float> widths = widthsOfButtons(labels);
    for (const Desk::As as : {Desk::As::Seen, Desk::As::Values}) {
        const bool values = as == Desk::As::Values;
        if (values)
            ImGui::SameLine();
        const char* const label = labels[values];
        if (button(label, widths[values]))
            ImGui::OpenPopup(label);
        if (ImGui::BeginPopup(label)) {
            for (const LivePicture picture : picturesOf(desk.state->settings.mode, desk.layers))
                if (desk.state->picture(picture) && ImGui::Selectable(livePictureName(picture)))
                    desk.save(picture, as);
            if (desk.state->loss && ImGui::Selectable(values ? "loss (CSV)" : "loss"))
                desk.saveLoss(as);
            ImGui::EndPopup();
        }
    }
    if (button("Scene with values recovered", ImGui::GetContentRegionAvail().x))
        desk.saveScene();
}

} // namespace

float controlsWidth() {
    return std::round(21 * ImGui::GetFontSize());
}

void drawControls(Desk& desk, const Rectangle& area) {
    ImGui::SetNextWindowPos({area.x, area.y});
    ImGui::SetNextWindowSize({area.width, area.height});
    ImGui::Begin("controls", nullptr, ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove |
                                          ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    drawScene(desk);
    drawError(desk);
    drawMode(desk);
    drawRun(desk);
    drawFigures(desk);
    section("Parameters");
    const bool optimizes = desk.state->settings.mode == LiveMode::Optimize;
    drawParameters(desk, optimizes ? 3 : 8);
    if (optimizes) {
        section("Recovery");
        drawOptimization(desk);
    }
    section("Guide");
    drawSampling(desk);
    section("View");
    if (!optimizes)
        drawCamera(desk);
    drawLook(desk);
    section("Save");
    drawSave(desk);
    ImGui::End();
}

} // namespace cmpg::viewer
