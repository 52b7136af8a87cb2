// What the window remembers besides the work.
#include "viewer/desk.h"

#include <algorithm>

namespace cmpg::viewer {
namespace {

std::string joined(const std::vector<std::string>& words) {
    std::string list;
    for (const std::string& word : words)
        list += (list.empty() ? "" : ", ") + word;
    return list;
}

// As it is where the working folder is gone.
std::filesystem::path absolute(const std::filesystem::path& file) {
    std::error_code gone;
    const std::filesystem::path whole = std::filesystem::absolute(file, gone);
    return gone ? file : whole;
}

} // namespace

void Desk::update() {
    state = session.state();
    if (state->message.number != seenMessage) {
        seenMessage = state->message.number;
        saved = state->message.text;
    }
    if (state->error.number != seenError) {
        seenError = state->error.number;
        fileError.clear(); // the newer one counts
    }
    if (state->scene && state->scene->number != wantedOf) {
        wantedOf = state->scene->number;
        wanted.clear();
    }
    if (state->pick && state->pick->number != seenPick) {
        seenPick = state->pick->number;
        if (state->pick->hit && state->scene) {
            pivot = state->pick->position;
            pivotScene = state->scene->number;
        }
    }
    refreshPick();
}

void Desk::fail(const std::string& what) {
    closeError();
    fileError = what;
}

const LiveError* Desk::openError() const {
    const LiveError& error = state->error;
    return error.number > closedError && !error.what.empty() ? &error : nullptr;
}

void Desk::closeError() {
    closedError = state->error.number;
    fileError.clear();
}

// What the guide learned since is worth another look, from where the first one was.
void Desk::refreshPick() {
    if (!inspector || !state->pick || !state->pick->hit)
        return;
    const LivePick& pick = *state->pick;
    const LiveSettings &now = state->settings, &then = pick.settings;
    if (state->guidePasses == pick.guidePasses || now.scene != then.scene || now.mode != then.mode || now.view != then.view ||
        (camera() && now.camera.toWorld != then.camera.toWorld))
        return;
    if (refreshedPick == pick.number && refreshedPasses == state->guidePasses)
        return; // its answer is under way
    refreshedPick = pick.number;
    refreshedPasses = state->guidePasses;
    // The pixel that the middle of this one is in: the size may have changed.
    const glm::ivec2 size = imageSize();
    session.pick((2 * pick.x + 1) * size.x / (2 * pick.width), (2 * pick.y + 1) * size.y / (2 * pick.height));
}

glm::vec3 Desk::pivotOf(const Camera& camera) const {
    if (!state->scene)
        return {};
    return pivot && pivotScene == state->scene->number ? *pivot : pivotAhead(camera, state->scene->lower, state->scene->upper);
}

void Desk::changeCamera(const std::function<void(Camera&)>& edit) {
    if (camera() && state->scene)
        session.change([&](LiveSettings& settings) { edit(settings.camera); });
}

void Desk::resetCamera() {
    pivot.reset();
    changeCamera([&](Camera& camera) {
        const auto& cameras = state->scene->cameras;
        const auto same = std::find_if(cameras.begin(), cameras.end(), [&](const Camera& c) { return c.name == camera.name; });
        camera = same == cameras.end() ? cameras.front() : *same;
    });
}

glm::ivec2 Desk::imageSize() const {
    const auto& image = state->picture(LivePicture::Image);
    if (camera() || !image)
        return {state->settings.width, state->settings.height};
    return {image->width, image->height};
}

void Desk::pick(glm::ivec2 pixel, const Image& shown) {
    const glm::ivec2 size = imageSize();
    inspector = true;
    session.pick(pixel.x * size.x / shown.width, pixel.y * size.y / shown.height);
}

void Desk::applyLayers() {
    session.change([&](LiveSettings& settings) { settings.layers = layers || cells; });
}

std::string Desk::sceneName() const {
    if (!state->scene)
        return "no scene";
    const std::filesystem::path file = absolute(state->scene->file);
    return (file.parent_path().filename() / file.filename()).string();
}

std::filesystem::path Desk::fileFor(const std::string& name, const char* extension) const {
    std::string stem = name;
    std::replace(stem.begin(), stem.end(), ' ', '-');
    const std::filesystem::path file = absolute(state->scene ? state->scene->file : "scene");
    const std::string scene = file.stem() == "scene" ? file.parent_path().filename().string() : file.stem().string();
    return std::filesystem::path(folder.empty() ? "." : folder) / (scene + "-" + stem + extension);
}

void Desk::save(LivePicture picture, As as) {
    if (state->picture(picture))
        session.save(picture, fileFor(livePictureName(picture), as == As::Seen ? ".png" : ".exr"), looks.forFile(*state, picture));
}

void Desk::saveLoss(As as) { session.saveLoss(fileFor("loss", as == As::Seen ? ".png" : ".csv")); }

void Desk::saveMeant(As as) {
    if (overLoss)
        saveLoss(as);
    else
        save(hover ? hover->picture : LivePicture::Image, as);
}

void Desk::saveScene() {
    if (state->scene)
        session.saveScene(fileFor("recovered", ""));
}

void Desk::open(const std::vector<std::filesystem::path>& files) {
    fileError.clear();
    const std::vector<std::string> scenes = v1::Scene::extensions();
    std::optional<std::filesystem::path> scene;
    std::optional<std::string> target;
    for (const auto& file : files) {
        std::string ending = file.extension().string();
        std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
        if (std::find(scenes.begin(), scenes.end(), ending) != scenes.end())
            scene = file;
        else if (ending == ".exr" || ending == ".hdr" || ending == ".png" || ending == ".jpg" || ending == ".jpeg")
            target = file.string();
        else
            fail(file.filename().string() + " is neither a scene (" + joined(scenes) + ") nor a target (.exr .hdr .png .jpg)");
    }
    if (scene)
        session.openScene(*scene, target);
    else if (target)
        session.openTarget(*target);
}

} // namespace cmpg::viewer
