// How the window draws an image: what the host tells the shaders of a panel.
#ifndef CMPG_SHARED_PANEL
#define CMPG_SHARED_PANEL
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// What a pixel's channels mean.
CMPG_CONST kPanelColor = 0;       // linear RGB, times `factor`, encoded as sRGB
CMPG_CONST kPanelSigned = 1;      // mean over the channels times `factor`, in [-1,1]: diverging colours
CMPG_CONST kPanelScalar = 2;      // first channel times `factor`, in [0,1]: colours of growing lightness
CMPG_CONST kPanelLogarithmic = 3; // first channel times `factor`, over `decades` powers of ten up to 1; 0 is black
CMPG_CONST kPanelCells = 4;       // first channel is a number: a colour of its own for each
CMPG_CONST kPanelDirection = 5;   // a direction in [-1,1]^3 as a colour, as normal maps are stored
CMPG_CONST kPanelPlain = 6;       // nothing but `background`

// The colour maps, rows of one texture with kPanelMapEntries columns from their lowest value to their highest.
CMPG_CONST kPanelMapEntries = 1024;
CMPG_CONST kPanelMapSigned = 0;
CMPG_CONST kPanelMapHeat = 1;
CMPG_CONST kPanelMapLabels = 2; // no order: a colour for each number, modulo the entries
CMPG_CONST kPanelMaps = 3;

struct PanelPush {
    vec2 place, extent; // of the whole image in the window, pixels
    vec2 window;        // extent of the window, pixels
    uint width, height; // of the image, texels
    uint kind;          // one of the above
    uint channels;      // that count, 1 or 3
    float factor, decades;
    float opacity;
    vec4 background;    // sRGB-encoded; kPanelPlain
};

CMPG_SHARED_END
#endif
