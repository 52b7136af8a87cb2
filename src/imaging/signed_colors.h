// Diverging colours for signed data: blue below zero, orange above, white at zero.
#pragma once

#include "imaging/color.h"
#include "imaging/drawing.h"

namespace cmpg {

// `t` in [-1,1], clamped. t and -t have the same lightness, so that neither sign looks stronger; blue against orange stays apart for
// every common kind of colour blindness. Not a number: grey.
Color signedColor(double t);

// The mean over the channels, which is what is coloured.
Image channelMean(const Image& image);

// The value that gets the deepest colour: the 99.5th percentile of |value|, so that single noisy pixels do not wash out the rest;
// rounded up to two digits, as it is printed. 1 for an image of zeros.
double signedScale(const Image& values);

Image colorSigned(const Image& values, double scale); // one channel in, RGB out

// A bar of the colours with -scale, 0 and scale under it, `width` wide; kSignedLegendHeight high.
constexpr int kSignedLegendHeight = 24;
void drawSignedLegend(Drawing& drawing, int x, int y, int width, double scale);

} // namespace cmpg
