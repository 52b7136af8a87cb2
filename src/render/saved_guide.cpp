// The guide of a renderer as a file of a scene.
#include "render/saved_guide.h"

#include "base/error.h"

#include <algorithm>

namespace cmpg {
namespace {

std::vector<std::string> sortedNames(const Scene& scene, const std::vector<std::uint32_t>& parameters) {
    std::vector<std::string> names;
    for (const std::uint32_t p : parameters)
        names.push_back(scene.parameters[p].name);
    std::sort(names.begin(), names.end());
    return names;
}

} // namespace

LoadedGuide readGuide(const std::filesystem::path& file, const Scene& scene, const std::vector<std::uint32_t>* parameters) {
    LoadedGuide guide = loadGuide(file);
    if (guide.context.geometry != geometryHash(scene))
        throw Error(ErrorKind::Input, "'" + file.string() + "' was learned in another scene", "the scene's triangles are not those of the guide",
                    "use the scene it was saved with, or learn a new one and save it", {"train", "save-guide"});
    std::vector<std::string> names = guide.context.parameters;
    std::sort(names.begin(), names.end());
    if (parameters && names != sortedNames(scene, *parameters))
        throw Error(ErrorKind::Input, "'" + file.string() + "' was learned for other parameters",
                    names.empty() ? "it was saved by a run that differentiates none"
                                  : "it was saved for " + names.front() + (names.size() > 1 ? " and others" : ""),
                    "name the same parameters, or learn a new one and save it", {"param", "train", "save-guide"});
    return guide;
}

void writeGuide(const std::filesystem::path& file, const Scene& scene, const std::vector<std::uint32_t>& parameters, const Renderer& renderer,
                const GuidedPasses& passes) {
    GuideContext context = passes.guideContext();
    context.geometry = geometryHash(scene);
    context.parameters = sortedNames(scene, parameters);
    saveGuide(file, renderer.guide(), context);
}

} // namespace cmpg
