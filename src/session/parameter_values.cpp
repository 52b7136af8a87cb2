// Values users give for parameters: --texture, --set, --direction, adjoints.
#include "session/parameter_values.h"

#include "base/error.h"
#include "base/log.h"
#include "scene/parameter_size.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>

namespace cmpg {
namespace {

std::string sizeText(std::size_t width, std::size_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

// The image of a file as entries of a parameter. One channel serves all; of three equal ones a scalar takes the first.
std::vector<float> readEntries(const Parameter& parameter, const std::string& file) {
    const Image image = readImage(file).image;
    if (std::size_t(image.width) != parameter.width || std::size_t(image.height) != parameter.height)
        throw Error(ErrorKind::Input,
                    "'" + file + "' is " + sizeText(image.width, image.height) + ", but " + parameter.name + " has " +
                        sizeText(parameter.width, parameter.height) + " entries",
                    "the image was made for another parameter", "give an image of the parameter's own size, or a number, or give the parameter that size (--texture)");
    std::vector<float> values(parameter.entries());
    for (std::size_t p = 0; p < image.pixels(); ++p)
        for (std::uint32_t c = 0; c < parameter.channels; ++c)
            values[p * parameter.channels + c] = image.values[p * image.channels + std::min<int>(c, image.channels - 1)];
    for (float v : values)
        if (!std::isfinite(v))
            throw Error(ErrorKind::Input, "'" + file + "' holds values that are not finite", "", "repair the image");
    return values;
}

} // namespace

std::optional<std::vector<float>> parseNumbers(const std::string& text) {
    std::vector<float> numbers;
    const char* at = text.c_str();
    while (true) {
        char* end = nullptr;
        numbers.push_back(std::strtof(at, &end));
        if (end == at)
            return {};
        if (*end == 0)
            return numbers;
        if (*end != ',')
            return {};
        at = end + 1;
    }
}

TextureAssignment parseTexture(const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    unsigned width = 0, height = 0;
    int length = -1;
    const std::string size = equals == std::string::npos ? "" : assignment.substr(equals + 1);
    if (std::sscanf(size.c_str(), "%5ux%5u%n", &width, &height, &length) != 2)
        length = -1;
    if (equals == 0 || length != int(size.size()) || width < 1 || height < 1 || width > kMostTexels || height > kMostTexels)
        throw Error(ErrorKind::Usage, "--texture takes P=WxH, not '" + assignment + "'", "", "give from 1 to " + std::to_string(kMostTexels) + " texels along each edge, such as P=64x64");
    return {assignment.substr(0, equals), width, height};
}

std::vector<std::uint32_t> applyTexture(Scene& scene, const std::string& assignment) {
    const TextureAssignment wanted = parseTexture(assignment);
    std::vector<std::uint32_t> selected = scene.select(wanted.name);
    for (const std::uint32_t index : selected)
        resize(scene, index, wanted.width, wanted.height);
    return selected;
}

std::vector<std::uint32_t> applySet(Scene& scene, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    const std::string name = assignment.substr(0, equals), value = equals == std::string::npos ? "" : assignment.substr(equals + 1);
    if (name.empty() || value.empty())
        throw Error(ErrorKind::Usage, "--set takes P=VALUE or P=FILE, not '" + assignment + "'");
    const auto numbers = parseNumbers(value);
    std::vector<std::uint32_t> selected = scene.select(name);
    for (const std::uint32_t index : selected) {
        Parameter& parameter = scene.parameters[index];
        setValues(parameter, numbers ? filled(parameter, *numbers) : readEntries(parameter, value));
    }
    return selected;
}

std::vector<std::uint32_t> selectParameters(const Scene& scene, std::span<const std::string> globs) {
    std::vector<std::string> left;
    std::vector<std::uint32_t> selected = scene.selectDifferentiable(globs, &left);
    std::string names;
    for (const std::string& name : left)
        names += (names.empty() ? "" : ", ") + name;
    if (!left.empty())
        logWarn("left out, for there is no derivative, or the material does not read it: " + names);
    return selected;
}

std::vector<float> directionOf(const Parameter& parameter, const std::string& direction) {
    if (direction == "one")
        return std::vector<float>(parameter.entries(), 1.0f);
    if (direction == "self")
        return valuesOf(parameter);
    return readEntries(parameter, direction);
}

} // namespace cmpg
