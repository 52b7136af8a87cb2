// What a kernel is specialised for: the ids of the specialization constants, in the order of FeatureSet::constants().
#ifndef CMPG_SHARED_FEATURES
#define CMPG_SHARED_FEATURES
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kFeatureMode = 0; // kModeRender ... kModeDifference
CMPG_CONST kFeatureDifferentiated = 1; // bit per slot kind; bit kSlotRadiance: of the environment
CMPG_CONST kFeatureDiffuse = 2; // some material has a diffuse lobe
CMPG_CONST kFeatureSpecular = 3;
CMPG_CONST kFeatureTextures = 4; // bit per slot kind that some material reads through a texture
CMPG_CONST kFeaturePackedSlots = 5; // bit per slot kind of which some texture has 8 bits a channel
CMPG_CONST kFeatureVertexNormals = 6;
CMPG_CONST kFeatureTexcoord1 = 7;
CMPG_CONST kFeatureColors = 8;
CMPG_CONST kFeatureTangents = 9;
CMPG_CONST kFeatureAlphaMask = 10;
CMPG_CONST kFeatureEmission = 11; // some material emits
CMPG_CONST kFeatureEnvironment = 12;
CMPG_CONST kFeatureTriangleLights = 13; // light sampling of ...
CMPG_CONST kFeaturePunctualLights = 14;
CMPG_CONST kFeatureEnvironmentLight = 15;
CMPG_CONST kFeatureSobol = 16;
CMPG_CONST kFeatureFrozen = 17; // f is evaluated with a second set of values
CMPG_CONST kFeatureLayers = 18; // first-hit features are written
CMPG_CONST kFeatureGuided = 19; // directions are drawn from the guide too
CMPG_CONST kFeatureRecord = 20; // vertices leave records for the guide
CMPG_CONST kFeatureRoulette = 21; // paths end and split by what the guide expects of them
CMPG_CONST kFeatureMeasure = 22; // the second moment of the paths' contributions is measured, reverse mode
CMPG_CONST kFeatureSigned = 23; // positivization: derivative terms of one sign only
CMPG_CONST kFeatureLightCandidates = 24; // light samples of which one is taken; 1: nothing to choose from; 0: several, as the scene says
CMPG_CONST kFeatureFewLights = 25; // 2, 4: so many at most, and their records stand in registers; 0: any number
CMPG_CONST kFeatureModels = 26; // bit per kModel... that some material has, and:
CMPG_CONST kModelsSmooth = 0x100u; // some boundary is smooth
CMPG_CONST kModelsRoughReflection = 0x200u; // some conductor or plastic is not
CMPG_CONST kModelsRoughDielectric = 0x400u;
CMPG_CONST kModelsBeckmann = 0x800u; // some rough boundary has Beckmann's microfacets
CMPG_CONST kModelsGgx = 0x1000u; // some has GGX's
CMPG_CONST kModelsAbsorbing = 0x4000u; // some dielectric absorbs light in its interior
CMPG_CONST kModelsCoatNormals = 0x8000u; // some clear coat has normals of its own
CMPG_CONST kModelsOneSided = 0x2000u; // some surface, of whatever model, is black from behind
CMPG_CONST kFeatureSpotsByAngle = 27; // some spot falls off with the angle
CMPG_CONST kFeatureAttributeTexels = 28; // vec4s a vertex
CMPG_CONST kFeatureClass = 29; // shade_vertex: whose vertices it takes, kClass...
CMPG_CONST kFeatureClassDifferentiated = 30; // shade_vertex: some slot that scattering depends on is, of that class
CMPG_CONST kFeatureClasses = 31; // sort_vertices: bit per class that has a kernel
CMPG_CONST kFeatureSingleDirections = 32; // rays may come from smooth boundaries, whatever class they meet
CMPG_CONST kFeatureCoverage = 33; // some alpha is the share of rays that meet a surface
CMPG_CONST kFeaturePixelFilter = 34; // some camera has another than the box
CMPG_CONST kFeatureColorSlots = 35; // bit per slot kind of which some texture has three channels
CMPG_CONST kFeatureScalarSlots = 36; // ... has one
CMPG_CONST kFeatureWrap = 37; // of all textures: 0 repeat, 1 clamp, 2 mirror; or
CMPG_CONST kWrapsDiffer = 3u;
CMPG_CONST kFeatureFilter = 38; // of all textures:
CMPG_CONST kFilterLinear = 0u;
CMPG_CONST kFilterNearest = 1u;
CMPG_CONST kFiltersDiffer = 2u;
CMPG_CONST kFeatureTextureTransforms = 39; // some texture's coordinates are moved
CMPG_CONST kFeatureCount = 40;

// The tracing kernels have a list of their own: FeatureSet::traceConstants().
CMPG_CONST kTraceThreads = 0; // threads of a CPU driver's static work split, 1 on a GPU
CMPG_CONST kTraceAlphaMask = 1; // as kFeatureAlphaMask; the rest matters only with it
CMPG_CONST kTraceAttributeTexels = 2; // vec4s a vertex
CMPG_CONST kTraceTexcoord1 = 3;
CMPG_CONST kTraceColors = 4;
CMPG_CONST kTraceStack = 5; // groups of children that traversal keeps in registers; 0: in an array, for deeper trees
CMPG_CONST kMaxTraceStack = 12;
CMPG_CONST kTraceCoverage = 6; // as kFeatureCoverage
CMPG_CONST kTraceCount = 7;

CMPG_CONST kModeRender = 0;
CMPG_CONST kModeForward = 1;
CMPG_CONST kModeReverse = 2;
CMPG_CONST kModeDifference = 3; // an image, and how it differs from that of the second set of values along the same paths

// Dimension sets of one path vertex's random numbers; each is a 4-D point of its own.
CMPG_CONST kSetCamera = 0; // bounce 0 only: pixel x, y
CMPG_CONST kSetScatter = 1; // direction x, y, lobe, technique
CMPG_CONST kSetLight = 2; // light, x, y; which candidate
CMPG_CONST kSetRoulette = 3; // copies of an arriving path; whether one goes on
CMPG_CONST kSetBlend = 4; // which of two materials is met

CMPG_SHARED_END
#endif
