// The shader library compiled as C++ in double precision: the yardstick for the float build.
#pragma once

#include "base/double_shader.h"
#include "shared/batch.h"
#include "shared/guide.h"
#include "shared/material.h"

#include <vector>

namespace cmpg::shader_double {
using namespace double_shader;
using gpu::kSpatialLeaf, gpu::kMaxSpatialLevels, gpu::kMaxQuadDepth;
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
