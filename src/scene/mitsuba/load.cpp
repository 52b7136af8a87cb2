// Reads a Mitsuba scene: the order of the steps, the integrator, and what is said about things left out.
#include "scene/mitsuba/load.h"

#include "base/error.h"
#include "scene/mitsuba/mitsuba.h"

#include <algorithm>
#include <limits>
#include <new>

namespace cmpg {
namespace {

constexpr const char* kExtensions[] = {".xml"};

bool beginsXml(std::span<const std::uint8_t> head) {
    const auto first = std::find_if(head.begin(), head.end(), [](std::uint8_t c) { return c > ' ' && c < 0x80; }); // after spaces and a byte order mark
    return first != head.end() && *first == '<';
}

// What may stand in a scene; each has its own step.
void checkContents(const MitsubaLoad& load) {
    for (const MitsubaElement* e : load.document.contents()) {
        const MitsubaElement& element = load.document.resolve(*e);
        if (!element.isObject())
            continue; // properties of the scene itself
        constexpr const char* kKnown[] = {"integrator", "sensor", "bsdf", "texture", "shape", "emitter", "film", "sampler", "rfilter", "spectrum"};
        if (std::none_of(std::begin(kKnown), std::end(kKnown), [&](const char* tag) { return element.tag == tag; }))
            load.document.fail(element, "the element " + element.tag.substr(0, 64) + " is not supported", "participating media and volumes are not rendered",
                               "leave it out");
    }
}

// The one that says how light travels: others only record more about its paths.
MitsubaObject innermostIntegrator(MitsubaLoad& load, const MitsubaObject& outermost) {
    constexpr int kMostLevels = 8;
    MitsubaObject integrator = outermost;
    for (int depth = 0; depth < kMostLevels; ++depth) {
        const std::vector<MitsubaObject> nested = integrator.objects("integrator");
        if (nested.empty())
            return integrator;
        if (nested.size() > 1)
            load.warn("of the integrators within " + integrator.type().substr(0, 64) + ", the first is rendered");
        integrator = nested.front();
    }
    outermost.fail("integrators are nested too deeply", "", "at most " + std::to_string(kMostLevels) + " levels are read");
}

} // namespace

const SceneFormat kMitsuba = {"Mitsuba XML", kExtensions, beginsXml, loadMitsuba, writeMitsuba, "scene.xml"};

void MitsubaLoad::noteUnread(const MitsubaObject& object) {
    for (const std::string& what : object.unread())
        ignored.insert(what + " of " + object.type());
}

std::string MitsubaLoad::nameOf(const MitsubaObject& object, const char* fallback) {
    return object.id().empty() ? fallback + std::to_string(object.element().line) : object.id();
}

void loadMitsubaIntegrator(MitsubaLoad& load) {
    constexpr std::uint32_t kUnlimited = 32, kMost = 1024;
    // What they all converge to is the image of a path tracer, where there are no media.
    constexpr const char* kPaths[] = {"path", "volpath", "volpathmis", "volpath_simple", "prb", "prb_basic", "prb_projective", "prbvolpath", "ptracer",
                                      "bdpt", "mlt", "pssmlt", "erpt", "photonmapper", "ppm", "sppm", "vpl"};
    for (const MitsubaElement* e : load.document.contents()) {
        const MitsubaObject outermost(load.document, *e);
        if (outermost.tag() != "integrator")
            continue;
        const MitsubaObject integrator = innermostIntegrator(load, outermost);
        const std::string& type = integrator.type();
        const bool direct = type.starts_with("direct");
        if (!direct && std::none_of(std::begin(kPaths), std::end(kPaths), [&](const char* known) { return type == known; }))
            load.warn("the integrator " + type.substr(0, 64) + " is not supported: paths are rendered in place of it");
        const std::int64_t depth = direct ? 2 : integrator.integer("max_depth", -1, -1, std::numeric_limits<std::int32_t>::max());
        load.scene.maxDepth = std::uint32_t(depth);
        if (depth < 0 || depth > kMost) {
            load.scene.maxDepth = kUnlimited;
            load.warn((depth < 0 ? "paths have no limit in the scene" : "paths may have " + std::to_string(depth) + " segments in the scene") +
                      "; here they end after " + std::to_string(kUnlimited) + " segments");
        }
        if (depth == 0)
            integrator.fail("a max_depth of 0 renders nothing", "", "use 1 for lights that are seen directly");
        if (integrator.boolean("hide_emitters", false))
            load.warn("hide_emitters is not supported: the camera sees lights directly");
        return;
    }
}

Scene loadMitsuba(const std::filesystem::path& file, const LoadOptions& options) {
    const MitsubaDocument document(file, options.definitions);
    MitsubaLoad load(document, options);
    load.scene.source = file.string();
    load.scene.files = document.files();
    for (const std::string& name : document.unusedDefinitions())
        load.warn("no variable of the scene is called " + name.substr(0, 64));
    checkContents(load);
    orientMitsubaScene(load);
    loadMitsubaShapes(load);
    load.geometry.finish(load.scene);
    loadMitsubaSensors(load);
    load.ensureCamera();
    loadMitsubaLights(load);
    if (options.environment.file.empty())
        loadMitsubaEnvironment(load);
    else
        load.applyOptions();
    loadMitsubaIntegrator(load);
    load.summarise();
    return std::move(load.scene);
}

} // namespace cmpg
