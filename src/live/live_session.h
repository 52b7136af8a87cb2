// The work behind a window: rendering, differentiating and optimising one scene on a thread of its own. Knows nothing of windows.
//
// A front end sets wishes and reads snapshots; neither ever waits for the work. Wishes are merged: of several that arrive while the worker
// is busy the last one counts. What takes long is interrupted between two submissions, each of which takes about 20 ms.
#pragma once

#include "base/error.h"
#include "session/options.h"

#include <cmpg/renderer.h>

#include <array>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <optional>

namespace cmpg {

enum class LiveMode {
    Render,   // the image, refined sample by sample
    Gradient, // the derivative image of the selected parameters as `gradient` makes it (all entries growing alike), and the image
    Optimize, // steps towards the targets; while paused, image and derivative image are refined
};

// What can be looked at. Present in a state where there is something to show, see LiveState::pictures.
enum class LivePicture {
    Image,             // RGB radiance
    Target,            // Optimize: of the view shown
    Difference,        // Optimize: Image - Target; signed
    Gradient,          // dImage/dparameters, in the image's shape; signed
    Parameter,         // current values of the first selected parameter, in its own shape (1 or 3 channels)
    ParameterGradient, // Optimize: of the loss by these values, in the same shape, of the last step; signed
    Normal, Depth, Albedo, // first hits, with LiveSettings::layers; world space; distance along the ray, 0 where nothing was hit
    Guided,                // share of the first directions that the guide drew, 0 to 1; with LiveSettings::layers
    Cells,                 // number of the guide's cell at the first hit, -1 for none; with LiveSettings::layers, once there is a guide
};
constexpr std::size_t kLivePictures = std::size_t(LivePicture::Cells) + 1;
const char* livePictureName(LivePicture picture); // "image", "target", ...: for titles and file names

// Everything a user sets. Values out of range are brought back into it. `settings` of a state are those in force.
struct LiveSettings {
    // Number of the scene that camera, parameters and view are meant for (LiveScene::number). Those three are ignored if it is another
    // than the one at work: a scene that was opened in the meantime starts with its own.
    std::uint32_t scene = 0;
    LiveMode mode = LiveMode::Render;
    bool running = true; // false: pause. Optimize: no steps, image and gradient go on refining; else: nothing goes on
    v1::CameraInfo camera; // Render, Gradient. Optimize has the cameras of its targets
    int width = 512, height = 512;          // of the image; Optimize: those of the targets
    std::vector<std::uint32_t> parameters;  // selected: into LiveScene::parameters
    std::uint32_t view = 0;                 // Optimize: target whose pictures are shown
    Sampling sampling = Sampling::Auto;
    float rateFactor = 1;                   // on all learning rates
    std::uint32_t spp = 16, sppGradient = 4; // Optimize: per pixel and step
    std::uint32_t sppLimit = 4096;          // refinement of image and gradient ends here, per pixel
    bool layers = false;                    // also make Normal, Depth, Albedo, Guided, Cells
};

// What stays the same until another scene is opened.
struct LiveScene {
    std::uint32_t number = 0; // counts scenes opened
    std::string file;
    std::vector<v1::ParameterInfo> parameters;
    std::vector<v1::CameraInfo> cameras; // never empty
    glm::vec3 lower{0}, upper{0}; // the box around all triangles, for moving about
    // The scene's own origin is here subtracted from all positions, cameras and picks included: add it to show a position.
    glm::dvec3 center{0};
    std::vector<std::string> warnings;
};

// What a click on the image found.
struct LivePick {
    std::uint32_t number = 0; // counts picks
    int x = 0, y = 0;         // pixel
    int width = 0, height = 0; // of the image that it is a pixel of
    LiveSettings settings;    // in force when it was answered
    std::uint32_t guidePasses = 0; // what the guide had learned from then
    bool hit = false;         // all below only where something was hit
    glm::vec3 position{0}, normal{0}; // coordinates as the cameras'; the triangle's normal, towards the camera
    std::string material;
    std::optional<v1::GuidePoint> guide; // what it knows there; none where it has not learned yet
    // P, D+, D-, mixture: density relative to that of uniform directions on the equal-area square: GuidePoint::density().
    std::array<std::shared_ptr<const Image>, 4> maps;
};

// What went wrong. The work goes on with what was there before.
struct LiveError {
    std::uint32_t number = 0; // counts errors; 0: none so far
    std::string what, cause, remedy; // empty: a scene or a target that opened since has settled it
    bool saving = false;             // of a file that could not be written, which no other scene settles
};

// A message of something done, such as a file saved.
struct LiveMessage {
    std::uint32_t number = 0; // counts messages
    std::string text;
};

// One moment, immutable. Pictures are shared between states while they stay the same: compare pointers to see what changed.
struct LiveState {
    std::uint64_t version = 0;                // counts states
    std::shared_ptr<const LiveScene> scene;   // null until one could be loaded
    LiveSettings settings;                    // in force
    std::array<std::shared_ptr<const Image>, kLivePictures> pictures{}; // null: nothing to show
    const std::shared_ptr<const Image>& picture(LivePicture p) const { return pictures[std::size_t(p)]; }

    std::uint32_t imageSamples = 0;    // per pixel, of Image; of one that is carried, of a step
    std::uint32_t gradientSamples = 0; // per pixel, of Gradient
    // Gradient is a fading mean over the last steps, whose parameters differed: only while an optimisation runs.
    bool gradientFading = false;
    // Image is the one that the steps carry on, which gathers the samples of many: until a refined one has less noise.
    bool imageCarried = false;
    bool preview = false;  // Image (and Gradient) are of a smaller size, made in haste: the view has just changed
    bool refining = false; // false: paused, or sppLimit is reached, or there is nothing to do
    double samplesPerSecond = 0;

    // Optimize
    std::uint32_t views = 0, step = 0;                    // targets; steps done
    std::shared_ptr<const std::vector<double>> loss;      // before each step; null before the first
    std::vector<std::string> targets;                     // files, one per view
    double secondsPrimal = 0, secondsGradient = 0, secondsUpdate = 0; // of the last step
    double rate = 0;                                      // of the first parameter in the last step

    // Guide
    bool guideLearned = false;
    std::uint32_t guideCells = 0, guidePasses = 0; // cells; passes or steps learned from
    Sampling sampling = Sampling::Bsdf;            // decided for derivative passes; Render mode: for images
    bool roulette = false;
    double guidedShare = 0; // of all directions drawn since the last change of settings

    std::string device;  // its name; empty until it is open
    std::string notice;  // what takes a while ("compiling kernels"), or what is missing ("select a parameter"); empty: nothing to say
    bool busy = false;   // the notice is about work going on
    bool dead = false;   // nothing can go on: no device, or no scene; `error` says why. Another scene may still be opened
    LiveError error;     // the last one
    LiveMessage message; // the last one
    std::shared_ptr<const LivePick> pick; // the last one; null: none
};

// How the values of a picture become colours, in a window as in PNG files.
enum class LiveColors {
    Radiance,   // as they are, times 2^exposure
    Plain,      // as they are: colours of materials
    Signed,     // blue below zero, orange above
    Heat,       // of one channel: from night blue at zero to cream
    Directions, // [-1,1] as [0,1]
    Labels,     // numbers: a colour of its own for each
};
LiveColors colorsOf(const LiveState& state, LivePicture picture);
const v1::ParameterInfo* shownParameter(const LiveState& state); // whose values and gradient are pictures; null: none

// How a picture becomes a PNG. EXR files always hold the values as they are.
struct LiveLook {
    float exposure = 0;  // Radiance
    double scale = 0;    // Signed, Heat: the value at the end of the colours; 0: automatic, as `view --signed`, or the largest
    bool legend = true;  // Signed: a bar with the scale under the picture
};

class LiveSession {
  public:
    // Starts the work and returns at once; device and scene are opened by the worker. `options`: as for the headless commands; of interest
    // are the scene, --param, --set, --target, --sampling, --spp, sizes, --seed, --device and so on, whatever the command. Without --param the
    // first textured parameter is selected; without --target a file target.exr beside the scene is taken if there is one.
    // `notify` is called by the worker whenever there is a new state; it must return quickly, and may be called from before the
    // constructor returns until the destructor does.
    explicit LiveSession(const Options& options, std::function<void()> notify = {});
    // Ends the work after the submission in flight. Files that were asked for are written first.
    ~LiveSession();
    LiveSession(const LiveSession&) = delete;
    LiveSession& operator=(const LiveSession&) = delete;

    // All of these return at once and may be called from any thread.

    std::shared_ptr<const LiveState> state() const; // the latest; never null

    void set(const LiveSettings& settings);
    LiveSettings settings() const; // as wished last: what to change and hand to set()
    // settings() changed in one go, without a race between reading and setting.
    void change(const std::function<void(LiveSettings&)>& edit);

    void stepOnce(std::uint32_t steps = 1); // Optimize, while paused: so many steps more
    // Parameters back to the scene's initial values (--set included), step and losses to 0; the guide forgets.
    void reset();
    // All entries of the selected parameters become this, within their range: something to recover from. Restarts as reset() does.
    void fill(float value);
    void train(std::uint32_t passes = 1); // Render, Gradient: learning passes for the guide
    // With its target, if one is given. What was asked for before is void, targets included: it was meant for the scene before. But files are written.
    void openScene(const std::filesystem::path& file, const std::optional<std::string>& target = {});
    // "FILE" or "CAMERA=FILE". Replaces all targets; without a camera, the scene's camera by the name of settings().camera is taken. Of a scene that is
    // still to be opened, it is that scene's.
    void openTarget(const std::string& target);
    void useImageAsTarget(); // what `Image` shows now, with its camera, replaces all targets
    void pick(int x, int y); // pixel of an Image of the size in the settings (Optimize: the target's), row 0 on top

    // What the latest state shows, as .exr or .png by the file's ending. The message, or the error, tells of the result.
    void save(LivePicture picture, const std::filesystem::path& file, const LiveLook& look = {});
    void saveLoss(const std::filesystem::path& file); // .png: the curve; .csv: the values
    // The scene with the values that were optimised so far, in the format of its file: `folder`/scene.gltf or scene.xml, and what it refers to.
    void saveScene(const std::filesystem::path& folder);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cmpg
