// A 5x7 font for labels in pictures: printable ASCII.
#pragma once

namespace cmpg {

constexpr int kGlyphWidth = 5, kGlyphHeight = 7, kGlyphAdvance = 6;
constexpr int kGlyphDescent = 2; // rows that some small letters reach below the others

// Whether a pixel of a character is set; (0,0) is the top left one, rows go on to kGlyphHeight + kGlyphDescent. Characters without a glyph show as '?'.
bool glyphPixel(char character, int x, int y);

} // namespace cmpg
