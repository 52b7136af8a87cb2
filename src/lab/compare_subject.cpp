// What a comparison differentiates, and a renderer for each of its methods.
#include "lab/compare_subject.h"

#include "base/error.h"
#include "optimize/losses.h"
#include "session/render_options.h"
#include "session/output.h"
#include "session/parameter_values.h"
#include "session/session.h"
#include "session/targets.h"

#include <algorithm>
#include <sstream>

namespace cmpg {
namespace {

constexpr std::uint32_t kPicturePass = 7; // random numbers of pictures made for the report
constexpr std::uint32_t kDiscarded = ~0u; // step of the pass thrown away

constexpr std::pair<CompareMode, const char*> kModes[] = {
    {CompareMode::Forward, "forward"}, {CompareMode::Reverse, "reverse"}, {CompareMode::Optimize, "optimize"}};

} // namespace

const char* compareModeName(CompareMode mode) {
    for (const auto& [value, name] : kModes)
        if (value == mode)
            return name;
    return "";
}

std::vector<CompareMode> parseModes(const std::string& list) {
    std::vector<CompareMode> modes;
    std::istringstream in(list + ",");
    for (std::string part; std::getline(in, part, ',');) {
        const auto* known = std::find_if(std::begin(kModes), std::end(kModes), [&](const auto& m) { return part == m.second; });
        if (known == std::end(kModes))
            throw Error(ErrorKind::Usage, "--mode: there is no mode '" + part + "'", "", "modes are forward, reverse and optimize");
        if (std::find(modes.begin(), modes.end(), known->first) == modes.end())
            modes.push_back(known->first);
    }
    return modes;
}

CompareSubject::CompareSubject(const Options& o)
    : options(o), modes(parseModes(o.mode)), methods(parseMethods(o.methods, o)), scene(readScene(o)) {
    if (has(CompareMode::Reverse) && o.adjoint.empty() && o.target.empty())
        throw Error(ErrorKind::Usage, "--mode reverse needs --target or --adjoint", "", "or compare derivative images: --mode forward");
    if (has(CompareMode::Optimize) && o.target.empty())
        throw Error(ErrorKind::Usage, "--mode optimize needs --target");
    if (o.target.size() > 1 && (modes.size() > 1 || !has(CompareMode::Optimize)))
        throw Error(ErrorKind::Usage, "several --target go with --mode optimize alone", "", "give one target, or compare optimisations");
    if (modes.size() > 1 && o.reference != "auto")
        throw Error(ErrorKind::Usage, "--reference FILE goes with one mode at a time", "", "leave it away, or run the modes one by one");

    parameters = selectParameters(scene, o.param);
    for (const std::uint32_t p : parameters) {
        scene.parameters[p].materialise();
        truth.push_back(scene.parameters[p].values);
    }
    scene = openScene(o); // again: with --set
    for (const std::uint32_t p : parameters) {
        scene.parameters[p].materialise();
        if (has(CompareMode::Forward))
            directions.push_back(directionOf(scene.parameters[p], o.direction));
    }
    std::string camera;
    const Image* like = nullptr;
    if (!o.target.empty()) {
        CameraTarget chosen = loadCameraTarget(o, scene, o.target.front());
        camera = chosen.camera;
        target = std::move(chosen.target);
        like = &target.image;
    } else if (!o.adjoint.empty()) {
        adjoint = readColorImage(o.adjoint);
        like = &adjoint;
    }
    constexpr int kDefaultWidth = 256; // many passes of many methods
    view = viewOf(o, scene, camera, like, kDefaultWidth);
    for (std::size_t i = 1; i < o.target.size(); ++i) {
        CameraTarget further = loadCameraTarget(o, scene, o.target[i]);
        furtherViews.push_back(viewOf(o, scene, further.camera, &further.target.image, kDefaultWidth));
        furtherTargets.push_back(std::move(further.target));
    }
}

bool CompareSubject::has(CompareMode mode) const { return std::find(modes.begin(), modes.end(), mode) != modes.end(); }

std::size_t CompareSubject::parameterEntries() const {
    std::size_t entries = 0;
    for (const std::uint32_t p : parameters)
        entries += scene.parameters[p].entries();
    return entries;
}

RenderConfig renderConfig(const CompareSubject& subject, const CompareMethod& method) {
    RenderConfig config = renderConfig(method.options, subject.scene, subject.parameters);
    config.guiding = method.learns();
    return config;
}

namespace {

void makePictures(Device& device, CompareSubject& subject, Report& report) {
    const bool needsAdjoint = subject.has(CompareMode::Reverse) && !subject.target.image.values.empty();
    constexpr std::uint32_t kPictureSpp = 64, kTrainSpp = 8, kTrainPasses = 8;
    CompareMethod method{{}, subject.options};
    method.options.sampling = Sampling::Auto;
    method.options.roulette = false;
    Renderer renderer(device, subject.scene, renderConfig(subject, method));
    renderer.prepare({Renderer::Mode::Render});
    GuidedPasses passes(renderer, guidedOptions(method.options));
    const Stopwatch watch;
    passes.trainRender(subject.view, kTrainSpp, kTrainPasses, subject.seed());
    subject.picture = passes.render(subject.view, needsAdjoint ? subject.options.adjointSpp : kPictureSpp,
                                    {.seed = subject.seed(), .pass = kPicturePass});
    report.seconds.primal += watch.seconds();
    if (needsAdjoint)
        subject.adjoint = evaluateLoss(subject.options.loss, subject.picture, subject.target.image, subject.target.mask).adjoint;
    report.addStatistics(renderer.statistics());
}

} // namespace

void beginComparison(Device& device, CompareSubject& subject, Report& report) {
    const std::filesystem::path folder = subject.options.output;
    requireWritableFolder(folder);
    report.width = subject.view.width;
    report.height = subject.view.height;
    report.seconds.load = report.elapsed();
    report.addDevice(device);
    printConfiguration(subject.options);
    writeRunJson(subject.options, folder, report);
    makePictures(device, subject, report);
}

MethodRenderer::MethodRenderer(Device& device, CompareSubject& subject, const CompareMethod& method)
    : subject_(subject), method_(method), renderer_(device, subject.scene, renderConfig(subject, method)),
      passes_(renderer_, guidedOptions(method.options)) {}

void MethodRenderer::train(CompareMode mode, std::uint32_t turn) {
    renderer_.prepare({mode == CompareMode::Forward ? Renderer::Mode::Forward : Renderer::Mode::Reverse});
    const std::uint32_t count = method_.options.effectiveTrain(), spp = method_.options.effectiveTrainSpp();
    const std::uint64_t seed = subject_.seed() + turn;
    const Stopwatch watch;
    if (method_.learns() && count > 0) {
        if (subject_.steps)
            passes_.trainRender(subject_.view, spp, count, seed);
        if (mode == CompareMode::Forward)
            passes_.trainForward(subject_.view, spp, count, seed, subject_.parameters, subject_.directions);
        else
            passes_.trainReverse(subject_.view, spp, count, seed, subject_.adjoint);
        trainSeconds_ += watch.seconds();
    }
    pass(mode, kDiscarded);
}

Pass MethodRenderer::pass(CompareMode mode, std::uint32_t index) {
    const PassKey key{.seed = subject_.seed(), .step = index, .pass = 1};
    const std::uint32_t spp = method_.options.effectiveSppGradient();
    Pass pass;
    const Stopwatch watch;
    if (mode == CompareMode::Forward) {
        const Image image = passes_.forward(subject_.view, spp, key, subject_.parameters, subject_.directions);
        pass.seconds = watch.seconds();
        pass.values.assign(image.values.begin(), image.values.end());
        pass.paths = std::uint64_t(spp) * image.pixels();
        return pass;
    }
    Image adjoint;
    if (subject_.steps) {
        const Image image = passes_.render(subject_.view, method_.options.effectiveSpp(), {.seed = subject_.seed(), .step = index});
        adjoint = evaluateLoss(subject_.options.loss, image, subject_.target.image, subject_.target.mask).adjoint;
        pass.paths = std::uint64_t(method_.options.effectiveSpp()) * image.pixels();
    }
    std::vector<std::vector<double>> gradients;
    for (const std::uint32_t p : subject_.parameters)
        gradients.emplace_back(subject_.scene.parameters[p].entries());
    pass.paths += passes_.reverse(subject_.view, spp, key, subject_.steps ? adjoint : subject_.adjoint, gradients);
    pass.seconds = watch.seconds();
    for (const auto& gradient : gradients)
        pass.values.insert(pass.values.end(), gradient.begin(), gradient.end());
    return pass;
}

std::string describeDecision(const CompareMethod& method, const SamplingDecision& decision) {
    std::string text;
    if (method.options.sampling == Sampling::Auto)
        text = samplingName(decision.method.kind);
    if (method.options.roulette)
        text += std::string(text.empty() ? "" : ", ") + (decision.method.roulette ? "roulette" : "no roulette");
    return text;
}

} // namespace cmpg
