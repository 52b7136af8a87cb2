// The specialization constants as GLSL constants; drivers remove what they switch off. On a CPU driver a branch that no lane takes still
// costs its instructions, so what a scene does not need must be switched off here.
#include "shared/features.h"
#include "shared/material.h"
layout(constant_id = kFeatureMode) const uint kMode = 0;
layout(constant_id = kFeatureDifferentiated) const uint kDifferentiated = 0;
layout(constant_id = kFeatureDiffuse) const bool kLobeDiffuse = true;
layout(constant_id = kFeatureSpecular) const bool kLobeSpecular = true;
layout(constant_id = kFeatureTextures) const uint kTexturedSlots = 0xff;
layout(constant_id = kFeaturePackedSlots) const uint kPackedSlots = 0xfff;
layout(constant_id = kFeatureVertexNormals) const bool kVertexNormals = true;
layout(constant_id = kFeatureTexcoord1) const bool kTexcoord1 = true;
layout(constant_id = kFeatureColors) const bool kColors = true;
layout(constant_id = kFeatureTangents) const bool kTangents = true;
layout(constant_id = kFeatureAlphaMask) const bool kAlphaMask = true;
layout(constant_id = kFeatureCoverage) const bool kCoverage = true;
layout(constant_id = kFeatureEmission) const bool kEmission = true;
layout(constant_id = kFeatureEnvironment) const bool kEnvironment = true;
layout(constant_id = kFeatureTriangleLights) const bool kTriangleLights = true;
layout(constant_id = kFeaturePunctualLights) const bool kPunctualLights = true;
layout(constant_id = kFeatureEnvironmentLight) const bool kEnvironmentLight = true;
layout(constant_id = kFeatureSobol) const bool kSobol = true;
layout(constant_id = kFeatureFrozen) const bool kFrozen = false;
layout(constant_id = kFeatureLayers) const bool kLayers = false;
layout(constant_id = kFeatureGuided) const bool kGuided = false;
layout(constant_id = kFeatureRecord) const bool kRecord = false;
layout(constant_id = kFeatureRoulette) const bool kRoulette = false;
layout(constant_id = kFeatureMeasure) const bool kMeasure = false;
layout(constant_id = kFeatureLightCandidates) const uint kLightCandidates = 8;
layout(constant_id = kFeatureFewLights) const uint kFewLights = 0;
layout(constant_id = kFeatureModels) const uint kModels = 1u << kModelMetallicRoughness;
layout(constant_id = kFeatureSigned) const bool kSigned = false;
layout(constant_id = kFeatureSpotsByAngle) const bool kSpotsByAngle = true;
layout(constant_id = kFeatureAttributeTexels) const uint kAttributeTexels = 2;
layout(constant_id = kFeatureClass) const uint kClass = 0;
layout(constant_id = kFeatureClassDifferentiated) const uint kClassDifferentiated = 1;
layout(constant_id = kFeatureClasses) const uint kClasses = 0;
layout(constant_id = kFeaturePixelFilter) const bool kPixelFilter = false;
layout(constant_id = kFeatureSingleDirections) const bool kSingleDirections = false;
layout(constant_id = kFeatureColorSlots) const uint kColorSlots = 0xfff;
layout(constant_id = kFeatureScalarSlots) const uint kScalarSlots = 0xfff;
layout(constant_id = kFeatureWrap) const uint kWrap = kWrapsDiffer;
layout(constant_id = kFeatureFilter) const uint kFilter = kFiltersDiffer;
layout(constant_id = kFeatureTextureTransforms) const bool kTextureTransforms = true;

// Single operations only: glslang 12 writes invalid SPIR-V for && between specialization constants. kDifferentiated is 0 in kModeRender.
#define SLOT(number, Name, name, channels, highest, adam, sgd) const bool kTextured##Name = (kTexturedSlots & (1u << number)) != 0;
#include "shared/slots.def"
const bool kBlend = kTexturedWeight; // some material is a blend
const bool kTextures = kTexturedSlots != 0 || kAlphaMask; // something is looked up at texture coordinates
const bool kMetallicRoughness = (kModels & (1u << kModelMetallicRoughness)) != 0;
const bool kOtherModels = (kModels & (1u << kModelDielectric | 1u << kModelThinDielectric | 1u << kModelConductor | 1u << kModelPlastic)) != 0;
const bool kDielectric = (kModels & (1u << kModelDielectric | 1u << kModelThinDielectric)) != 0;
const bool kConductor = (kModels & (1u << kModelConductor)) != 0;
const bool kPlastic = (kModels & (1u << kModelPlastic)) != 0;
const bool kSmoothLobes = (kModels & kModelsSmooth) != 0;
const bool kRoughDielectric = (kModels & kModelsRoughDielectric) != 0;
const bool kRoughReflection = (kModels & kModelsRoughReflection) != 0;
const bool kBeckmann = (kModels & kModelsBeckmann) != 0;
const bool kGgx = (kModels & kModelsGgx) != 0;
const bool kAbsorbing = (kModels & kModelsAbsorbing) != 0;
const bool kOneSided = (kModels & kModelsOneSided) != 0;
const bool kCoatNormals = (kModels & kModelsCoatNormals) != 0;
const bool kSpecularColor = (kModels & (1u << kModelDielectric | 1u << kModelThinDielectric | 1u << kModelPlastic)) != 0; // some specular slot is RGB
const bool kForward = kMode == kModeForward;
const bool kReverse = kMode == kModeReverse;
const bool kDifference = kMode == kModeDifference;
const uint kDerivativeMode = (kMode + 1) >> 1 & 1; // of modes 0 to 3: 0, 1, 1, 0
const bool kDerivatives = kDerivativeMode != 0;
const bool kLightSampling = kTriangleLights || kPunctualLights || kEnvironmentLight;
#define SLOT(number, Name, name, channels, highest, adam, sgd) const bool kDiff##Name = (kDifferentiated & (1u << number)) != 0;
#include "shared/slots.def"
const uint kSlotMaskLight = 1u << kSlotEmission | 1u << kSlotRadiance;
const uint kTapedSlots = kDifferentiated * kDerivativeMode; // whose derivatives are on the tape
const bool kDiffLight = (kTapedSlots & kSlotMaskLight) != 0; // a light sample's own radiance is differentiated
const bool kGuideLookup = kGuided || kRecord; // vertices find their cell
const bool kPrefix = kReverse || kGuideLookup; // what a path has collected so far travels with it, in derivative modes
const bool kPrefixTangent = kGuideLookup || kRoulette; // so does a bound on its derivative
const uint kSlotMaskSurface = ~kSlotMaskLight * kClassDifferentiated;
const bool kDiffSurface = (kTapedSlots & kSlotMaskSurface) != 0;
// Difference mode: only slots that are differentiated have another value in the second set. Both are evaluated where a surface or a light has such slots.
const uint kSecondSlots = kDifferentiated * (kMode & kMode >> 1 & 1); // of modes 0 to 3: 0, 0, 0, 1
const bool kSecondSurface = (kSecondSlots & kSlotMaskSurface) != 0;
const bool kSecondLight = (kSecondSlots & kSlotMaskLight) != 0;
const uint kKeptSlots = kDifferentiated & ~kSlotMaskLight;
// False: a pass makes nothing but derivatives by surfaces, and light that meets none of these on its way to the camera is not looked for.
const bool kAllLight = kDerivativeMode == 0 || kRecord || kDiffLight;
#include "lib/derivative_places.glsl"
