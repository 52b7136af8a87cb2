// Values users give for parameters: --texture, --set, --direction, adjoints.
#pragma once

#include "scene/image.h"
#include "scene/parameter_values.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// "0.5" or "r,g,b"; nothing if the text is neither (a file name, then).
std::optional<std::vector<float>> parseNumbers(const std::string& text);

struct TextureAssignment {
    std::string name; // or glob
    std::uint32_t width, height;
};
// Of "P=WxH". Error(Usage) on other text.
TextureAssignment parseTexture(const std::string& assignment);
std::vector<std::uint32_t> applyTexture(Scene& scene, const std::string& assignment); // resize(); returns the parameters that it named

// Applies "P=VALUE|FILE" (P a name or glob) to the scene. A number or r,g,b fills every entry; a file must have the parameter's own
// size. Returns the parameters that it named. Error(Usage) on text that means nothing, unknown parameters and values out of range; Error(Input) on files.
std::vector<std::uint32_t> applySet(Scene& scene, const std::string& assignment);

// As Scene::selectDifferentiable(); warns of what is left out.
std::vector<std::uint32_t> selectParameters(const Scene& scene, std::span<const std::string> globs);

// The direction of a forward derivative: "one", "self" or a file of the parameter's own size; entries() floats.
std::vector<float> directionOf(const Parameter& parameter, const std::string& direction);

} // namespace cmpg
