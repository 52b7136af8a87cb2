// The guide at a vertex: its cell and mixture, and the directions drawn from it and from the material in one (one-sample mix).
#include "shared/guide.h"
READ_UINT(guideSpatialWord, kBindGuideSpatial)
READ_UVEC4(guideCellTexel, kBindGuideCells)
READ_UVEC4(guideNode, kBindGuideNodes)
layout(binding = kBindGuideInfo, scalar) uniform GuideInfoBlock { GuideInfo guide; };

#include "lib/guide.glsl"

float meanOf(vec3 v) { return (v.x + v.y + v.z) * (1.0 / 3.0); }

uint guideCellOf(vec3 position) { return guideCellAt((position - guide.lower) * guide.inverseExtent); }

#ifdef CMPG_GUIDE_DIRECTIONS
// Materials smoother than this are better off alone; the threshold is on alpha, the square of glTF's roughness.
const float kGuidableAlpha = 0.2;

struct GuidePoint {
    uint cell, root;
    vec3 parts; // what P, D+, D- have of the mixture, with the sum 1; all 0: nothing is known
    bool guidable; // the material is not too smooth
    float share; // probability of drawing from the guide
};

GuidePoint guidePoint(vec3 position, Surface surface, Prefix prefix) {
    GuidePoint g = GuidePoint(kNone, 0, vec3(0), false, 0.0);
    if (!kGuideLookup) return g;
    g.cell = guideCellOf(position);
    const uint at = g.cell * kGuideCellTexels;
    g.root = guideCellTexel(at).x;
    const vec3 total = uintBitsToFloat(guideCellTexel(at + 1).xyz);
    vec3 weights = guideWeights(guide.kind, total, meanOf(prefix.tangent), meanOf(prefix.throughput), batch.sign);
    const vec3 defended = guideDefended(weights, total);
    weights = guide.kind == kGuideConditional ? defended : weights;
    g.parts = guideParts(weights, total);
    // Decided before anything is drawn: a cell that knows nothing must not be drawn from.
    g.guidable = hasDiffuse(surface) || smallestAlpha(surface) > kGuidableAlpha;
    if (kGuided && g.guidable && g.parts != vec3(0)) g.share = guide.share;
    return g;
}

// Density with which drawDirection() draws wi.
float mixtureDensity(GuidePoint g, Surface surface, vec3 normal, vec3 wo, vec3 wi) {
    const float material = bsdfPdf(surface, normal, wo, wi);
    if (!kGuided) return material;
    return mix(material, g.share > 0.0 ? guideDensity(g.root, g.parts, squareFromDirection(wi)) : 0.0, g.share);
}

// Draws wi with density `pdf`; u.w picks the technique and the part of the guide. `leaf`: the quadrant wi lies in; `guided`: the guide drew
// it. `single`: wi is a single direction of a smooth boundary and pdf the probability of it; no quadrant knows of it. False: nothing to go on with.
bool drawDirection(GuidePoint g, Surface surface, vec3 normal, vec3 wo, vec4 u, out vec3 wi, out float pdf, out uint leaf,
                   out bool guided, out bool single) {
    float probability;
    bool drawn = sampleBsdf(surface, normal, wo, u.xyz, wi, probability);
    single = kSmoothLobes && probability > 0.0;
    leaf = kNone;
    guided = false;
    pdf = 0.0;
    if (!kGuideLookup) {
        if (drawn) pdf = single ? probability : bsdfPdf(surface, normal, wo, wi);
        return drawn && pdf > 0.0;
    }
    guided = kGuided && u.w < g.share;
    const uint part = guided ? guidePart(g.parts, u.w / g.share) : 0;
    const GuideWalk walk = guideWalk(g.root, g.parts, guided, part, guided ? u.xy : squareFromDirection(wi));
    leaf = walk.leaf;
    if (guided) {
        wi = directionFromSquare(walk.point);
        drawn = walk.density > 0.0;
        single = false;
    }
    if (single) {
        leaf = kNone;
        pdf = probability * (1.0 - g.share);
        return drawn && pdf > 0.0;
    }
    pdf = mix(bsdfPdf(surface, normal, wo, wi), walk.density, g.share);
    return drawn && pdf > 0.0;
}
#endif
