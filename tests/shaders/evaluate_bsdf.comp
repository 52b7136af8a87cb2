// Evaluates a material for one pair of directions an invocation, as the renderer's kernels do.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
const bool kLobeDiffuse = true;
const bool kLobeSpecular = true;
const bool kOtherModels = false;
const bool kMetallicRoughness = true;
const bool kDielectric = false;
const bool kConductor = false;
const bool kPlastic = false;
const bool kSmoothLobes = false;
const bool kRoughDielectric = false;
const bool kRoughReflection = false;
const bool kBeckmann = false;
const bool kGgx = true;
const bool kOneSided = true;
const bool kCoatNormals = false;
#define SLOT(number, Name, name, channels, highest, adam, sgd) const bool kDiff##Name = true;
#include "shared/slots.def"
#define LOBE_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) const bool kTextured##Name = false;
#define LOBE_COLOR_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) const bool kTextured##Name = false;
#include "shared/slots.def"
#include "shared/material.h"
const uint kKeptSlots = kScatteringSlots & ((1u << kMaterialSlots) - 1u);
vec4 coatTexel(uint at) { return vec4(0); }
#include "lib/bsdf.glsl"
#include "lib/dispatch.glsl"

struct Query {
    vec3 baseColor;
    float roughness, metallic, specular;
    vec3 specularColor;
    float ior;
    uint model;
    vec3 normal, wo, wi;
    float clearcoat, clearcoatRoughness, anisotropy;
    vec3 tangent;
    float sheenRoughness;
    vec3 sheenColor;
    vec3 coatNormal;
};

struct Result {
    vec3 value; // of bsdfCos
    vec3 valueWithDerivatives;
    float pdf;
    vec3 baseColor, roughness, metallic, specular;
    vec3 normalX, normalY, normalZ;
};

layout(binding = 0, scalar) readonly buffer Queries { Query queries[]; };
layout(binding = 1, scalar) writeonly buffer Results { Result results[]; };
layout(push_constant) uniform Push { uint count; };

void main() {
    const uint i = globalIndex();
    if (i >= count) return;
    const Query q = queries[i];
    Surface s;
    s.baseColor = q.baseColor;
    s.roughness = q.roughness;
    s.metallic = q.metallic;
    s.specular = q.specular;
    s.specularColor = q.specularColor;
    s.ior = q.ior;
    s.asked = 0xffffffffu;
    s.model = q.model;
    BsdfDerivatives d;
    Result r;
    r.value = bsdfCos(s, q.normal, q.wo, q.wi);
    r.valueWithDerivatives = bsdfCosDerivatives(s, q.normal, q.wo, q.wi, d);
    r.pdf = bsdfPdf(s, q.normal, q.wo, q.wi);
    r.baseColor = d.at[kAtBaseColor];
    r.roughness = d.at[kAtRoughness];
    r.metallic = d.at[kAtMetallic];
    r.specular = d.at[kAtSpecular];
    r.normalX = d.at[kAtNormal];
    r.normalY = d.at[kAtNormal + 1];
    r.normalZ = d.at[kAtNormal + 2];
    results[i] = r;
}
