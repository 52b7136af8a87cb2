// Colours that a Mitsuba scene writes in other ways than <rgb>.
#pragma once

#include "scene/mitsuba/document.h"

namespace cmpg {

// <srgb> of version 0.6, and spectra that Mitsuba's rgb mode takes for a colour, become the same <rgb>, which Mitsuba 3 reads where the scene is written
// back. Other spectra are refused; other elements stay.
void becomeRgb(const MitsubaDocument& document, MitsubaElement& element);

} // namespace cmpg
