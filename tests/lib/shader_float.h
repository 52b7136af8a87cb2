// The shader library compiled as C++ in single precision, as a kernel computes it. Only for files compiled with
// -fsingle-precision-constant (see tests/CMakeLists.txt): otherwise the literals would be double.
#pragma once

#include "shared/batch.h"
#include "shared/guide.h"
#include "shared/material.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <type_traits>
#include <vector>

static_assert(std::is_same_v<decltype(1.0), float>, "compile this file with -fsingle-precision-constant");

namespace cmpg::shader_float {
using namespace glm;
using uint = std::uint32_t;
using gpu::kSpatialLeaf, gpu::kMaxSpatialLevels, gpu::kMaxQuadDepth;
using gpu::kQuadFractionBits, gpu::kQuadFractionOne, gpu::kQuadChildBits;
using gpu::kModelShift, gpu::kModelMask, gpu::kModelMetallicRoughness, gpu::kModelDielectric, gpu::kModelThinDielectric, gpu::kModelConductor, gpu::kModelPlastic;
using gpu::kMaterialSmooth, gpu::kMaterialBeckmann, gpu::kMaterialNonlinear, gpu::kMaterialAnisotropic, gpu::kMaterialSheen, gpu::kMaterialAlphaSquared, gpu::kMaterialAspect,
    gpu::kMaterialOneSided, gpu::kCoatRows, gpu::kCoatColumns;
using gpu::kFilterTent;
using gpu::kGuidePrimal, gpu::kGuideDifferential, gpu::kGuideUniform, gpu::kGuideConditional, gpu::kDefensiveParts;
#include "shader_library.inc"
} // namespace cmpg::shader_float
