// Steps of normals, each in the plane at right angles to it.
#include "optimize/tangent_plane.h"

#include "optimize/entry_loops.h"

#include <array>
#include <cmath>

namespace cmpg {
namespace {

using Vector = std::array<float, 3>;

// The axes turn with the normal smoothly but where it is the x axis: a step goes on in about the same direction after others.
struct TangentPlane {
    float length;
    Vector normal, axis[2]; // unit

    explicit TangentPlane(const float* n) : length(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])) {
        constexpr float kLeastLength = 1e-6f; // shorter ones have no direction: the surface's own normal
        normal = length > kLeastLength ? Vector{n[0] / length, n[1] / length, n[2] / length} : Vector{0, 0, 1};
        const auto [x, y, z] = normal;
        const float across = std::sqrt(y * y + z * z); // the x axis less its part along the normal is as long
        axis[0] = across > kLeastLength ? Vector{across, -x * y / across, -x * z / across} : Vector{0, 0, 1};
        const auto [u, v, w] = axis[0];
        axis[1] = {y * w - z * v, z * u - x * w, x * v - y * u};
    }
};

} // namespace

void toSteps(std::span<const float> normals, std::span<double> derivatives) {
    forEachEntry(normals.size() / 3, [&](std::size_t texel) {
        const TangentPlane plane(normals.data() + 3 * texel);
        double* d = derivatives.data() + 3 * texel;
        const auto along = [&](const Vector& axis) { return double(plane.length) * (axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2]); };
        const double first = along(plane.axis[0]), second = along(plane.axis[1]);
        d[0] = first;
        d[1] = second;
        d[2] = 0;
    });
}

void dropOtherAxis(std::size_t axis, std::span<double> derivatives) {
    forEachEntry(derivatives.size() / 3, [&](std::size_t texel) { derivatives[3 * texel + 1 - axis] = 0; });
}

void moveNormals(std::span<const float> steps, std::span<float> normals) {
    forEachEntry(normals.size() / 3, [&](std::size_t texel) {
        const float* step = steps.data() + 3 * texel;
        const TangentPlane plane(normals.data() + 3 * texel);
        Vector moved = plane.normal;
        for (std::size_t c = 0; c < 3; ++c)
            moved[c] += plane.axis[0][c] * step[0] + plane.axis[1][c] * step[1];
        const float length = std::sqrt(1 + step[0] * step[0] + step[1] * step[1]);
        for (std::size_t c = 0; c < 3; ++c)
            normals[3 * texel + c] = moved[c] / length;
    });
}

} // namespace cmpg
