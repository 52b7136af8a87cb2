// One pixel of an image in the window: the texels it covers, through a colour map.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shared/panel.h"

layout(push_constant, scalar) uniform Push { PanelPush panel; };
layout(set = 0, binding = 0) uniform texture2D image;
layout(set = 1, binding = 0) uniform texture2D maps;

layout(location = 0) in vec2 texel;
layout(location = 0) out vec4 color;

const uint kCheckDark = 44, kCheckLight = 60; // of the pattern where a value is not a number, 8-bit

vec3 encode(vec3 linear) {
    const vec3 v = clamp(linear, 0, 1);
    return mix(12.92 * v, 1.055 * pow(max(v, vec3(1e-6)), vec3(1 / 2.4)) - 0.055, greaterThan(v, vec3(0.0031308)));
}

// Enlarged: the one texel, unfiltered, so that every value can be seen. Reduced: the mean over the texels a pixel covers.
vec3 value() {
    const ivec2 size = ivec2(panel.width, panel.height);
    const vec2 step = vec2(size) / panel.extent;
    if (max(step.x, step.y) <= 1)
        return texelFetch(image, clamp(ivec2(floor(texel)), ivec2(0), size - 1), 0).rgb;
    const int kMost = 16; // texels along an edge that are read; far smaller pictures are not worth more
    const vec2 low = texel - 0.5 * step;
    const ivec2 count = clamp(ivec2(ceil(step)), ivec2(1), ivec2(kMost));
    vec3 sum = vec3(0);
    for (int y = 0; y < count.y; ++y)
        for (int x = 0; x < count.x; ++x)
            sum += texelFetch(image, clamp(ivec2(floor(low + (vec2(x, y) + 0.5) * step / vec2(count))), ivec2(0), size - 1), 0).rgb;
    return sum / (count.x * count.y);
}

// t in [0,1], between the two nearest entries. The maps are in linear light.
vec3 mapped(uint map, float t) {
    const float place = clamp(t, 0, 1) * float(kPanelMapEntries - 1);
    const int entry = min(int(place), int(kPanelMapEntries) - 2);
    return encode(mix(texelFetch(maps, ivec2(entry, map), 0).rgb, texelFetch(maps, ivec2(entry + 1, map), 0).rgb, place - float(entry)));
}

void main() {
    if (panel.kind == kPanelPlain) {
        color = panel.background;
        return;
    }
    vec3 v;
    if (panel.kind == kPanelCells)
        v = texelFetch(image, clamp(ivec2(floor(texel)), ivec2(0), ivec2(panel.width, panel.height) - 1), 0).rgb; // numbers have no mean
    else
        v = value();
    const float mean = panel.channels == 1 ? v.r : (v.r + v.g + v.b) / 3;
    if (any(isnan(v)) || any(isinf(v))) {
        const uvec2 block = uvec2(gl_FragCoord.xy) / 4;
        color = vec4(vec3(((block.x + block.y) & 1) == 0 ? kCheckDark : kCheckLight) / 255, 1);
        return;
    }
    vec3 rgb = vec3(0);
    if (panel.kind == kPanelColor)
        rgb = encode((panel.channels == 1 ? v.rrr : v) * panel.factor);
    else if (panel.kind == kPanelSigned)
        rgb = mapped(kPanelMapSigned, 0.5 + 0.5 * mean * panel.factor);
    else if (panel.kind == kPanelScalar)
        rgb = mapped(kPanelMapHeat, v.r * panel.factor);
    else if (panel.kind == kPanelLogarithmic)
        rgb = v.r > 0 ? mapped(kPanelMapHeat, 1 + log(v.r * panel.factor) / (log(10) * panel.decades)) : vec3(0);
    else if (panel.kind == kPanelDirection)
        rgb = encode(0.5 + 0.5 * v);
    else
        rgb = v.r < 0 ? vec3(0) : encode(texelFetch(maps, ivec2(uint(v.r) % kPanelMapEntries, kPanelMapLabels), 0).rgb);
    color = vec4(rgb, panel.opacity);
}
