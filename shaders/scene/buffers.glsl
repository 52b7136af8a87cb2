// The scene's read-only tables, for kernels that look at surfaces and lights.
#include "shared/bindings.h"
#include "shared/wavefront.h"
#include "shared/light.h"
#include "shared/scene_info.h"
#include "shared/batch.h"
#include "scene/material_tables.glsl"
READ_VEC4(triangleTexel, kBindTriangles)
READ_UVEC4(lightTexel, kBindLights)
READ_FLOAT(lightDensity, kBindLightDensity)
READ_FLOAT(environmentCdf, kBindEnvironmentCdf)
layout(binding = kBindScene, scalar) uniform SceneBlock { SceneInfo scene; };
layout(binding = kBindBatch, scalar) uniform BatchBlock { Batch batch; };
