// Functions of the shader library by name, in the float and in the double build, on the same float arguments.
#pragma once

#include "lib/evaluate.h"
#include "lib/guide_table.h"

#include <array>
#include <cstdint>
#include <vector>

namespace cmpg::test {

enum class Function {
    AreaToSolidAngle,     // density, squared distance, cosine
    DistanceFalloff,      // squared distance, range
    SpotFalloff,          // cosine, inner, outer
    MisWeight,            // own, other
    EnvironmentUv,        // direction
    EnvironmentDirection, // uv
    EnvironmentPoint,     // across, row, down, height
    SampleLinear,         // u, a, b
    CellOf,               // uv, width, height
    SquareFromDirection,  // direction
    DirectionFromSquare,  // point
    TexelValue,           // uv, width, height, wrap of u, of v, nearest: of a grid of 1 + column / width + 2 row / height
    EnvironmentTexelValue, // uv, width, height: the same
    CosineHemisphere,     // u
    GgxNormal,            // alpha, wo, u
    Frame,                // n: both tangents
};

using Numbers = std::vector<double>;
Numbers callFloat(Function function, const std::vector<float>& arguments);
Numbers callDouble(Function function, const std::vector<float>& arguments);

// A direction drawn from a material, and what it counts.
struct Drawn {
    bool any;
    glm::vec3 wi;
    double density;
    glm::dvec3 weight; // f cos over the density
};
Drawn sampleFloat(const Query& query, const std::array<float, 3>& u);
Drawn sampleDouble(const Query& query, const std::array<float, 3>& u);

// The guide's mixture in a cell: what a path makes of it, and what it draws from the random numbers `u`.
struct Mixture {
    std::uint32_t kind;
    int sign;
    float light, derivative; // what the path carries
};
struct GuideDraw {
    glm::dvec3 weights;
    double score; // 0: nothing to draw from
    glm::dvec2 point;
    double density, again; // of the draw; at its point, asked for alone
    std::uint32_t leaf;
};
GuideDraw drawFloat(const GuideTable& table, std::uint32_t cell, const Mixture& mixture, const glm::vec3& u);
// `at`: where the float build ended, whose density is wanted.
GuideDraw followDouble(const GuideTable& table, std::uint32_t cell, const Mixture& mixture, const glm::vec2& at);

} // namespace cmpg::test
