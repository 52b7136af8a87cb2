// What the rough dielectric coat of a plastic lets through.
#pragma once

#include "scene/scene.h"
#include "shared/material.h"

#include <map>
#include <span>

namespace cmpg {

// One index of refraction and one distribution of microfacets, every alpha. Single scattering, as in Mitsuba's `roughplastic`: what masking takes is lost.
class CoatTable {
  public:
    // ior: interior over exterior.
    CoatTable(double ior, Microfacets microfacets) : ior_(ior), microfacets_(microfacets) {}

    // Writes rows `first` to `last` of the texels that kernels read (kCoatRows, kCoatColumns in shaders/shared/material.h; texels: all of them).
    void write(std::uint32_t first, std::uint32_t last, std::span<glm::vec4> texels);
    // The row that alpha falls in, as lib/lobes/plastic.glsl finds it.
    static std::uint32_t rowOf(float alpha);

    // What a rough boundary makes of light that comes at `cosine` from where the index is 1 to where it is `eta`, both [0, 1].
    struct Passed {
        double reflected = 0, transmitted = 0;
    };
    static Passed passed(double cosine, double alpha, double eta, Microfacets microfacets);
    // What a smooth boundary reflects of diffuse light.
    static double reflectedDiffuse(double eta);

  private:
    struct Row {
        std::array<double, gpu::kCoatColumns> transmitted; // at equal steps of the cosine, 0 to 1
        double within;                                     // reflected of diffuse light from within
    };
    const Row& row(std::uint32_t index);

    double ior_;
    Microfacets microfacets_;
    std::map<std::uint32_t, Row> rows_;
};

} // namespace cmpg
