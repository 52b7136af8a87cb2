// What the window remembers besides the work: how things are looked at, what is open, where files go.
#pragma once

#include "live/live_session.h"
#include "viewer/camera_control.h"
#include "viewer/layout.h"
#include "viewer/picture_look.h"
#include "viewer/picture_view.h"

#include <optional>

namespace cmpg::viewer {

// A pixel under the cursor: all panels of the group mark it.
struct Hover {
    LivePicture picture;
    glm::ivec2 pixel;
};

struct Desk {
    explicit Desk(LiveSession& s) : session(s), state(s.state()) {}

    LiveSession& session;
    std::shared_ptr<const LiveState> state; // of this frame
    Looks looks;

    std::array<PictureView, 2> views; // by Group
    PictureView& viewOf(LivePicture picture) { return views[std::size_t(groupOf(picture))]; }
    std::optional<Rectangle> pictureArea; // of the first panel, last frame: what "actual size" goes by
    std::optional<Hover> hover, hoverFound; // of the last frame, which this one shows; in this one
    bool overLoss = false;                  // the cursor over the curve of the loss
    std::optional<glm::vec3> pivot; // where the last click hit; else straight ahead
    std::uint32_t pivotScene = 0;   // number of the scene it is in

    // Of W A S D Q E those that went down by themselves and still are: the S of Ctrl+S may stay down longer than the Ctrl.
    std::vector<int> flyKeys;

    bool layers = false, cells = false; // more panels; cells of the guide over the image
    bool help = false, inspector = false;
    std::uint32_t seenPick = 0, closedError = 0;
    std::uint32_t refreshedPick = 0, refreshedPasses = 0; // the pick that was asked for again, and what the guide had learned from then
    float fill = 0.5f; // what a recovery starts from
    std::string wanted;         // part of the names of the parameters that are listed
    std::uint32_t wantedOf = 0; // number of the scene whose parameters these are
    std::optional<glm::vec3> direction, directionFound; // under the cursor in a map of the guide: last frame, this frame
    std::string folder = ".";
    std::string saved, fileError; // the last message of something done, and what went wrong in the window's own doing
    std::uint32_t seenMessage = 0, seenError = 0;
    bool quit = false;

    void update(); // takes over the latest state
    void fail(const std::string& what); // in the window's own doing
    const LiveError* openError() const; // of the work, to be shown; null: none
    void closeError();
    void refreshPick();

    bool camera() const { return state->settings.mode != LiveMode::Optimize; } // it can be moved
    glm::vec3 pivotOf(const Camera& camera) const;
    void changeCamera(const std::function<void(Camera&)>& edit);
    void resetCamera();
    glm::ivec2 imageSize() const;  // of Image as wished: what is shown may be a smaller preview
    void pick(glm::ivec2 pixel, const Image& shown);
    void applyLayers(); // asks the work for what `layers` and `cells` show
    std::string sceneName() const; // folder and name of the file, as many are called scene.gltf
    std::filesystem::path fileFor(const std::string& name, const char* extension) const; // in `folder`, of this scene
    enum class As { Seen, Values }; // PNG as it looks; EXR or CSV
    void save(LivePicture picture, As as);
    void saveLoss(As as);
    void saveMeant(As as); // what is under the cursor, else the image
    void saveScene();
    // Scenes and targets, by their endings, as they were dropped together: the targets are those of the scene, whatever the order.
    void open(const std::vector<std::filesystem::path>& files);
};

} // namespace cmpg::viewer
