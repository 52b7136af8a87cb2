// Functions of the shader library by name, in the float and in the double build, on the same float arguments.
#pragma once

#include <initializer_list>
#include <vector>

namespace cmpg::test {

enum class Function {
    AreaToSolidAngle,     // density, squared distance, cosine
    DistanceFalloff,      // squared distance, range
    SpotFalloff,          // cosine, inner, outer
    MisWeight,            // own, other
    EnvironmentUv,        // direction
    EnvironmentDirection, // uv
    CellSolidAngle,       // row, width, height
    CellSample,           // column, row, width, height, u
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

} // namespace cmpg::test
