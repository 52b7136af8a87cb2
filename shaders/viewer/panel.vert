// Corners of an image's rectangle in the window, from the vertex index alone.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/panel.h"

layout(push_constant, scalar) uniform Push { PanelPush panel; };

layout(location = 0) out vec2 texel; // position in the image, in texels

void main() {
    const vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1); // a strip of two triangles
    texel = corner * vec2(panel.width, panel.height);
    gl_Position = vec4(2 * (panel.place + corner * panel.extent) / panel.window - 1, 0, 1);
}
