// Binding numbers: one name per buffer, the same in every kernel.
#ifndef CMPG_SHARED_BINDINGS
#define CMPG_SHARED_BINDINGS
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// Scene, read only.
CMPG_CONST kBindNodes = 0; // Bvh::records: box nodes and leaf blocks, 4 uvec4 texels each
CMPG_CONST kBindTriangles = 1; // three vec4 a triangle in BVH order: v0, v1 - v0, v2 - v0; w: x, y, z of the face's normal
CMPG_CONST kBindIndices = 2; // uvec4 a triangle in BVH order: vertices, material
CMPG_CONST kBindAttributes = 3; // vec4s a vertex: normal and u0; v0, u1, v1; tangent; colour (the last two only where the scene has them)
CMPG_CONST kBindMaterials = 4; // uvec4 texels of GpuMaterial
CMPG_CONST kBindSlots = 5; // uvec4 texels of GpuSlot
CMPG_CONST kBindValues = 6; // vec4 texels of the parameters' values
CMPG_CONST kBindPacked = 7; // uint texels of packed textures
CMPG_CONST kBindLights = 8; // uvec4 texels of GpuLight
CMPG_CONST kBindLightDensity = 9; // float a triangle: probability per unit area that light sampling picks a point on it
CMPG_CONST kBindEnvironmentCdf = 10; // float: (H-1) marginal, then (H-1) x W conditional cumulative probabilities
CMPG_CONST kBindScene = 11; // SceneInfo

// The guide, read and written in layouts of shaders/shared/guide.h.
CMPG_CONST kBindGuideInfo = 12; // GuideInfo
CMPG_CONST kBindGuideSpatial = 13; // uint an octant of a spatial node
CMPG_CONST kBindGuideCells = 14; // uvec4 texels of GpuGuideCell
CMPG_CONST kBindGuideNodes = 15; // a uvec4 texel a quadtree node
CMPG_CONST kBindGuideLeafSums = 26; // GuideLeafSums a quadrant
CMPG_CONST kBindGuideCellSums = 27; // GuideCellSums a cell
CMPG_CONST kBindGuideVisits = 28; // GuideVisit a vertex
CMPG_CONST kBindPathMoments = 29; // PathMoment a path
CMPG_CONST kBindDifferenceFilm = 30; // FilmPixel, difference mode

// One batch.
CMPG_CONST kBindBatch = 16; // Batch
CMPG_CONST kBindPixelOffsets = 17; // uint a pixel + 1: first path of each pixel of the batch; then uint a pixel: its first sample
CMPG_CONST kBindPaths = 18; // uvec2 a path: pixel of the batch, sample of the pixel
CMPG_CONST kBindAdjoint = 19; // vec3 a pixel of the batch: dLoss/dpixel times the sample weight
CMPG_CONST kBindFilm = 20; // FilmPixel
CMPG_CONST kBindLayers = 21; // LayerSample a path
CMPG_CONST kBindGradients = 22; // 64-bit integers
CMPG_CONST kBindLayerFilm = 25; // LayerSample a pixel
CMPG_CONST kBindDirection = 23; // float an entry of the gradient: direction of the forward derivative
CMPG_CONST kBindStatistics = 24; // Statistics

// Rays and hits of one bounce.
CMPG_CONST kBindRays = 32;
CMPG_CONST kBindNextRays = 33;
CMPG_CONST kBindHits = 34;
CMPG_CONST kBindShadowRays = 35;
CMPG_CONST kBindCounts = 36; // QueueCounts a bounce
CMPG_CONST kBindCountsHere = 60; // the bounce's own, for what no invocation of the kernel changes: from a storage buffer a CPU driver reads lane by lane
CMPG_CONST kBindCountsFirst = 61; // the first bounce's, likewise
CMPG_CONST kBindVisibility = 37; // uint a shadow ray: 1 = visible
CMPG_CONST kBindPrefixes = 38; // Prefix a ray, derivative modes
CMPG_CONST kBindNextPrefixes = 39;

// The tape: this bounce's pool and the next one's.
CMPG_CONST kBindVertices = 40;
CMPG_CONST kBindSuffixes = 41; // vec4 a vertex: E_i + R_i, what the scan makes of it
CMPG_CONST kBindNextSuffixes = 31;
CMPG_CONST kBindTape = 42; // floats in planes of `capacity`, see shaders/shared/tape.h
CMPG_CONST kBindTangents = 43; // vec4 a vertex: forward mode, dE_i + T_i along the direction; difference mode, E_i + R_i under the second set of values
CMPG_CONST kBindNextTangents = 44;
CMPG_CONST kBindDerivatives = 45; // DerivativeParts a vertex, passes that record
CMPG_CONST kBindNextDerivatives = 46;
CMPG_CONST kBindMoments = 47; // VertexMoment a vertex, passes that measure
CMPG_CONST kBindNextMoments = 48;
CMPG_CONST kBindArrivals = 49; // Arrival a ray, roulette only
CMPG_CONST kBindNextArrivals = 50;
CMPG_CONST kBindCopies = 51; // Copy a vertex, roulette only

CMPG_CONST kBindSorted = 59; // uint a vertex: those of a class, from class * capacity on

// The self-test of a device: texels of each format that kernels read, and what it leaves.
CMPG_CONST kBindTestNodes = 52; // uvec4 a node: first of two children or 0 for a leaf; of a leaf: its vector, number and word
CMPG_CONST kBindTestVectors = 53; // vec4
CMPG_CONST kBindTestNumbers = 54; // float
CMPG_CONST kBindTestWords = 55; // uint
CMPG_CONST kBindTestCounts = 56; // SelfTestCounts
CMPG_CONST kBindTestSum = 57; // one 64-bit integer
CMPG_CONST kBindTestResults = 58; // SelfTestResult
CMPG_CONST kBindTestCountsHere = 62; // the counts as a uniform buffer, which another kernel wrote

CMPG_SHARED_END
#endif
