// The shader library compiled as C++ in double precision: the yardstick for the float build.
#pragma once

#include "shared/batch.h"
#include "shared/guide.h"
#include "shared/material.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace cmpg::shader_double {
using namespace glm;
using vec2 = glm::dvec2;
using vec3 = glm::dvec3;
using vec4 = glm::dvec4;
using uint = std::uint32_t;
using gpu::kSpatialLeaf, gpu::kMaxSpatialDepth, gpu::kMaxQuadDepth;
using gpu::kQuadFractionBits, gpu::kQuadFractionOne, gpu::kQuadChildBits;
using gpu::kModelShift, gpu::kModelMask, gpu::kModelMetallicRoughness, gpu::kModelDielectric, gpu::kModelThinDielectric, gpu::kModelConductor, gpu::kModelPlastic;
using gpu::kMaterialSmooth, gpu::kMaterialBeckmann, gpu::kMaterialNonlinear, gpu::kMaterialAnisotropic, gpu::kMaterialSheen, gpu::kMaterialAlphaSquared, gpu::kMaterialAspect,
    gpu::kMaterialOneSided, gpu::kCoatRows, gpu::kCoatColumns;
using gpu::kFilterTent;
using gpu::kGuidePrimal, gpu::kGuideDifferential, gpu::kGuideUniform, gpu::kGuideConditional, gpu::kDefensiveParts;
#define float double
#include "shader_library.inc"
#undef float
} // namespace cmpg::shader_double
