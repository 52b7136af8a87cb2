// Values of parameters: read, and set within their range.
#include "scene/parameter_values.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

void requireRange(const Parameter& parameter, std::vector<float>& values) {
    constexpr float kRounding = 1e-4f; // of files that went through another program
    float lowest = parameter.lowest(), highest = parameter.highest();
    if (parameter.kind == SlotKind::Normal) { // directions, of a map with its scale in them: their length says nothing
        lowest = -kLongestNormal;
        highest = kLongestNormal;
    }
    for (float& v : values) {
        if (!(v >= lowest - kRounding && v <= highest + kRounding) || std::isinf(v)) {
            char text[160];
            std::snprintf(text, sizeof text, "%g is out of the range of %s, [%g, %g]", double(v), parameter.name.c_str(), double(lowest),
                          double(highest));
            throw Error(ErrorKind::Usage, text, "", "give linear values within the range", {"inspect"});
        }
        v = std::clamp(v, lowest, highest);
    }
}

} // namespace

std::vector<float> valuesOf(const Parameter& parameter) {
    if (!parameter.values.empty())
        return parameter.values;
    Parameter copy = parameter;
    copy.materialise();
    return std::move(copy.values);
}

std::vector<float> filled(const Parameter& parameter, std::span<const float> numbers) {
    if (numbers.size() != 1 && numbers.size() != parameter.channels)
        throw Error(ErrorKind::Usage,
                    parameter.name + " has " + std::to_string(parameter.channels) + " channel(s), but " + std::to_string(numbers.size()) +
                        " values were given",
                    "", "give one number" + std::string(parameter.channels == 3 ? " or r,g,b" : ""));
    std::vector<float> values(parameter.entries());
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = numbers.size() == 1 ? numbers[0] : numbers[i % parameter.channels];
    return values;
}

void setValues(Parameter& parameter, std::vector<float> values) {
    requireRange(parameter, values);
    parameter.values = std::move(values);
    parameter.bytes.clear();
    parameter.bytes.shrink_to_fit();
}

} // namespace cmpg
