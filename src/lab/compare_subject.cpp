// What a comparison differentiates, and a renderer for each of its methods.
#include "lab/compare_subject.h"

#include "base/error.h"
#include "session/library_options.h"
#include "session/output.h"
#include "session/parameter_values.h"
#include "session/targets.h"

#include <algorithm>
#include <sstream>

namespace cmpg {
namespace {

constexpr std::uint32_t kPicture = ~0u, kDiscarded = ~1u; // indices of the picture for the report, and of passes thrown away

// Of the pass with this index.
std::uint64_t passSeed(std::uint64_t seed, std::uint32_t index) { return seed + 0x9e3779b97f4a7c15ull * (std::uint64_t(index) + 1); }

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

CompareSubject::CompareSubject(const Options& o, Report& report)
    : options(o), modes(parseModes(o.mode)), methods(parseMethods(o.methods, o)), session(o, report) {
    if (has(CompareMode::Reverse) && o.adjoint.empty() && o.target.empty())
        throw Error(ErrorKind::Usage, "--mode reverse needs --target or --adjoint", "", "or compare derivative images: --mode forward");
    if (has(CompareMode::Optimize) && o.target.empty())
        throw Error(ErrorKind::Usage, "--mode optimize needs --target");
    if (o.target.size() > 1 && (modes.size() > 1 || !has(CompareMode::Optimize)))
        throw Error(ErrorKind::Usage, "several --target go with --mode optimize alone", "", "give one target, or compare optimisations");
    if (modes.size() > 1 && o.reference != "auto")
        throw Error(ErrorKind::Usage, "--reference FILE goes with one mode at a time", "", "leave it away, or run the modes one by one");

    const auto unsampled = std::find_if(methods.begin(), methods.end(), [](const CompareMethod& m) { return m.options.noLightSampling; });
    if (unsampled != methods.end() && !o.noLightSampling) // else the session has said so
        warnOfUnsampledLights(unsampled->options, session.host());
    const Scene asInFile = readScene(o);
    for (std::size_t p = 0; p < session.parameters.size(); ++p) {
        truth.push_back(valuesOf(asInFile.parameters[asInFile.parameter(session.parameters[p])]));
        if (has(CompareMode::Forward))
            directions.push_back({session.parameters[p], directionOf(session.parameter(p), o.direction)});
    }
    constexpr int kDefaultWidth = 256; // many passes of many methods
    requireCamerasNamed(o, session.host());
    std::vector<std::string> cameras;
    for (const std::string& text : o.target) {
        v1::Target given = averagedTo(o, openTarget(o, session.scene, text));
        cameras.push_back(given.camera);
        const SeenView seen = viewOf(o, session.host(), given.camera, &given.image, kDefaultWidth);
        if (targets.empty())
            view = seen;
        given.camera = seen.camera;
        targets.push_back(std::move(given));
    }
    if (!targets.empty()) {
        requireMasksOf(o, session.host(), cameras);
        return;
    }
    if (!o.adjoint.empty())
        adjoint = readColorImage(o.adjoint);
    view = viewOf(o, session.host(), "", o.adjoint.empty() ? nullptr : &adjoint, kDefaultWidth);
}

bool CompareSubject::has(CompareMode mode) const { return std::find(modes.begin(), modes.end(), mode) != modes.end(); }

std::size_t CompareSubject::parameterEntries() const {
    std::size_t entries = 0;
    for (std::size_t p = 0; p < session.parameters.size(); ++p)
        entries += session.parameter(p).entries();
    return entries;
}

std::string CompareSubject::parameterNames() const {
    std::string names;
    for (const std::string& name : session.parameters)
        names += (names.empty() ? "" : ", ") + name;
    return names;
}

v1::PathOptions CompareSubject::paths(const CompareMethod& method) const {
    return pathOptions(method.options, method.options.effectiveDepth(session.host().maxDepth));
}

v1::PassOptions CompareSubject::pass(std::uint32_t spp, std::uint64_t seed) const {
    return {.camera = view.camera, .width = view.width, .height = view.height, .spp = spp, .seed = seed};
}

Image CompareSubject::adjointOf(const Image& image) const {
    return v1::lossOf(options.loss, image, targets.front()).adjoint;
}

namespace {

void makePictures(CompareSubject& subject, Report& report) {
    const bool needsAdjoint = subject.has(CompareMode::Reverse) && !subject.targets.empty();
    constexpr std::uint32_t kPictureSpp = 64, kTrainSpp = 8, kTrainPasses = 8;
    CompareMethod method{{}, subject.options};
    method.options.sampling = Sampling::Auto;
    v1::Renderer renderer(subject.session.openDevice(), subject.session.scene, {.paths = subject.paths(method), .parameters = subject.session.parameters});
    v1::PassOptions how = subject.pass(needsAdjoint ? subject.options.adjointSpp : kPictureSpp, passSeed(subject.seed(), kPicture));
    how.train = kTrainPasses;
    how.trainSpp = kTrainSpp;
    renderer.prepare({v1::PassKind::Render}, how);
    v1::PassReport pass;
    subject.picture = renderer.render(how, &pass);
    report.seconds.primal += pass.seconds;
    if (needsAdjoint)
        subject.adjoint = subject.adjointOf(subject.picture);
    subject.session.add(pass);
}

} // namespace

void beginComparison(CompareSubject& subject, Report& report) {
    requireWritableFolder(subject.options.output);
    subject.session.openDevice();
    subject.session.begin(subject.view, subject.options.output);
    makePictures(subject, report);
}

MethodRenderer::MethodRenderer(CompareSubject& subject, const CompareMethod& method)
    : subject_(subject), method_(method),
      renderer_(subject.session.openDevice(), subject.session.scene, {.paths = subject.paths(method), .parameters = subject.session.parameters}) {}

void MethodRenderer::train(CompareMode mode, std::uint32_t turn) {
    const std::uint32_t learn = method_.learns() ? method_.options.effectiveTrain() : 0;
    const v1::PassKind kind = mode == CompareMode::Forward ? v1::PassKind::Forward : v1::PassKind::Backward;
    v1::PassOptions how;
    how.train = learn;
    if (subject_.steps) // also image and derivative share a guide
        renderer_.prepare({v1::PassKind::Render, kind}, how);
    else
        renderer_.prepare({kind}, how);
    passAfter(mode, passSeed(subject_.seed() + turn, kDiscarded), learn);
}

Pass MethodRenderer::pass(CompareMode mode, std::uint32_t index) { return passAfter(mode, passSeed(subject_.seed(), index), 0); }

Pass MethodRenderer::passAfter(CompareMode mode, std::uint64_t seed, std::uint32_t learn) {
    v1::PassOptions how = subject_.pass(method_.options.effectiveSppGradient(), seed);
    how.train = learn;
    how.trainSpp = method_.options.effectiveTrainSpp();
    how.strict = false; // what was left out is told at the end
    Pass pass;
    const auto count = [&] {
        subject_.session.add(last_);
        pass.seconds += last_.seconds;
        trainSeconds_ += last_.learningSeconds;
        pass.paths += std::uint64_t(last_.spp) * std::uint64_t(last_.width) * std::uint64_t(last_.height);
    };
    if (mode == CompareMode::Forward) {
        const Image image = renderer_.forward(subject_.directions, how, &last_);
        count();
        pass.values.assign(image.values.begin(), image.values.end());
        return pass;
    }
    Image adjoint;
    if (subject_.steps) {
        v1::PassOptions images = how;
        images.spp = method_.options.effectiveSpp();
        adjoint = subject_.adjointOf(renderer_.render(images, &last_));
        count();
        how.anew = false;
    }
    for (const std::vector<double>& gradient : renderer_.backward(subject_.steps ? adjoint : subject_.adjoint, how, &last_))
        pass.values.insert(pass.values.end(), gradient.begin(), gradient.end());
    count();
    return pass;
}

std::string describeDecision(const CompareMethod& method, const v1::PassReport& report) {
    std::string text;
    if (method.options.sampling == Sampling::Auto)
        text = nameOf(report.sampling, kSamplings);
    if (method.options.roulette)
        text += std::string(text.empty() ? "" : ", ") + (report.roulette ? "roulette" : "no roulette");
    return text;
}

} // namespace cmpg
