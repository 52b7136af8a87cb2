// Materials and their slots as the kernels read them: texels of four 32-bit words.
#ifndef CMPG_SHARED_MATERIAL
#define CMPG_SHARED_MATERIAL
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

#define SLOT(number, Name, name, channels, highest, adam, sgd) CMPG_CONST kSlot##Name = number;
#include "shared/slots.def"
CMPG_CONST kMaterialSlots = kSlotRadiance;
CMPG_CONST kCommonSlots = kSlotNormal + 1; // those that all materials have; LOBE_SLOTs follow, then colours of lobes
CMPG_CONST kFlaggedSlots = kSlotAnisotropy; // those that GpuMaterial::flags has two bits for, by number; the slots after them have bits of their own
CMPG_CONST kSlotsPerMaterial = kMaterialSlots; // places in the table of slots
CMPG_CONST kLobeSlots = kSlotSheenColor - kCommonSlots; // single numbers
CMPG_CONST kScatteringSlots = ((1u << kSlotsPerMaterial) - 1u) & ~(1u << kSlotEmission); // a bit for each that scattering may depend on

// How a surface scatters: SurfaceModel of src/scene/scene.h, which says what the slots of each mean.
CMPG_CONST kModelMetallicRoughness = 0;
CMPG_CONST kModelDielectric = 1;
CMPG_CONST kModelThinDielectric = 2;
CMPG_CONST kModelConductor = 3;
CMPG_CONST kModelPlastic = 4;

// Constant slots are read from here in two or three fetches; textured ones, and those of lobes, through their GpuSlot.
struct GpuMaterial {
    vec3 baseColor;
    float roughness;
    float metallic; // metallic-roughness; dielectric: absorption.x; plastic: what the coat reflects of diffuse light from within; conductor: eta.x
    float specular; // metallic-roughness; dielectric: absorption.y; rough plastic: the first texel of its table; conductor: eta.y
    float ior;      // conductor: eta.z
    uint flags;
    vec3 specularColor; // metallic-roughness: a constant; dielectrics and plastic: the specular slot; conductor: k
    float alphaCutoff; // of an alpha mask; dielectric: absorption.z
    vec3 emission;
    uint alphaSlot; // kNone without alpha mask
};
CMPG_CONST kMaterialTexels = 4;

// What rough coats of plastics let through, behind the materials: rows of texels by the square root of alpha, each with one texel an interval of
// cosines: the values at both of its ends, on this row and on the next; and one, the last, with what is reflected of diffuse light from within.
CMPG_CONST kCoatRows = 32;
CMPG_CONST kCoatColumns = 64;

// GpuMaterial::flags: bit k: slot k is read through its GpuSlot; bit 8 + k: slot k is differentiated; and:
CMPG_CONST kMaterialEmissive = 0x10000u;
CMPG_CONST kMaterialAlphaMask = 0x20000u;
CMPG_CONST kDifferentiatedShift = 8;
CMPG_CONST kModelShift = 18; // three bits: kModel...
CMPG_CONST kModelMask = 7u;
CMPG_CONST kMaterialSmooth = 0x200000u;
CMPG_CONST kMaterialBeckmann = 0x400000u; // of other models than metallic-roughness; of that:
CMPG_CONST kMaterialSheen = kMaterialBeckmann; // the two slots of sheen are read; their GpuSlots say whether they are differentiated
CMPG_CONST kMaterialNonlinear = 0x800000u; // of plastics; of others:
CMPG_CONST kMaterialAnisotropic = kMaterialNonlinear; // the anisotropy slot is read; its GpuSlot says whether it is differentiated
CMPG_CONST kMaterialAlphaSquared = 0x1000000u; // alpha is the square of the roughness slot; of metallic-roughness, whose alpha always is:
CMPG_CONST kMaterialAspect = kMaterialAlphaSquared; // anisotropy says how the two alphas relate, as in Disney's principled material
CMPG_CONST kMaterialClassShift = 25; // two bits: kClass..., of the kernel that shades it
CMPG_CONST kMaterialClassMask = 3u;
CMPG_CONST kMaterialCoverage = 0x10000000u; // of an alpha mask: alpha is the share of rays that meet the surface; alphaCutoff multiplies the threshold
CMPG_CONST kMaterialAbsorbs = 0x20000000u; // a dielectric's interior
CMPG_CONST kMaterialBlend = 0x40000000u; // the weight slot says which other material is met here, and how often
CMPG_CONST kMaterialWeightDifferentiated = 0x80000000u; // of a blend, on both of its materials
CMPG_CONST kMaterialOneSided = 0x8000000u; // black from behind; not of dielectrics

// Where a slot's values live and how a surface point finds them.
struct GpuSlot {
    uint offset; // of the first value, in vec4 texels; when packed, in 32-bit words
    uint width, height;
    uint flags;
    vec4 uvMatrix; // u' = x u + z v + translation.x, v' = y u + w v + translation.y
    vec2 uvTranslation;
    uint gradient; // first entry among the gradient sums; kNone when not differentiated
    uint other; // of a weight slot: the second material; of an anisotropy slot: the place of the directions in this table, kNone: along the tangent;
    // of a clearcoat slot: the place of the coat's own normals, kNone: those of what is below
    vec4 packedScale; // value = scale * decoded + bias, packed slots only
    vec4 packedBias;
};
CMPG_CONST kSlotTexels = 5;

// GpuSlot::flags
CMPG_CONST kSlotWrapUMask = 3u; // 0 repeat, 1 clamp, 2 mirror
CMPG_CONST kSlotWrapVShift = 2u;
CMPG_CONST kSlotNearest = 16u;
CMPG_CONST kSlotTexcoord1 = 32u;
CMPG_CONST kSlotScalar = 64u; // one channel instead of three
CMPG_CONST kSlotPacked = 128u; // 8 bits a channel, one texel per 32-bit word
CMPG_CONST kSlotSrgb = 256u; // packed values are sRGB-encoded
CMPG_CONST kSlotTangents1 = 512u; // of an anisotropy slot: where the file has no tangents, they are those of TEXCOORD_1

CMPG_SHARED_END
#endif
