// Where the derivatives by each slot stand in BsdfDerivatives and on the tape: those that are kept lie side by side, the normal's three, that of a
// blend's weight and the three of the sheen's colour at the end.
// The includer defines uint kKeptSlots: a bit for each scattering slot whose derivatives are kept.
#ifndef CMPG_LIB_DERIVATIVE_PLACES
#define CMPG_LIB_DERIVATIVE_PLACES
#include "shared/material.h"

// Bits that are set among the lowest sixteen, in operations that specialization constants know.
#define CMPG_BITS_OF_2(m) ((m) - ((m) >> 1 & 0x5555u))
#define CMPG_BITS_OF_4(m) ((CMPG_BITS_OF_2(m) & 0x3333u) + (CMPG_BITS_OF_2(m) >> 2 & 0x3333u))
#define CMPG_BITS_OF_8(m) ((CMPG_BITS_OF_4(m) + (CMPG_BITS_OF_4(m) >> 4)) & 0x0f0fu)
#define CMPG_BITS_OF_16(m) ((CMPG_BITS_OF_8(m) + (CMPG_BITS_OF_8(m) >> 8)) & 0x1fu)

const uint kKeptSurfaceSlots = kKeptSlots & ~(1u << kSlotNormal | 1u << kSlotSheenColor) & ((1u << kSlotWeight) - 1u);
#define SURFACE_SLOT(number, Name, name, channels, highest, adam, sgd) const uint kAt##Name = CMPG_BITS_OF_16(kKeptSurfaceSlots & ((1u << number) - 1u));
#include "shared/slots.def"
const uint kAtNormal = CMPG_BITS_OF_16(kKeptSurfaceSlots);
const uint kAtWeight = kAtNormal + 3u * (kKeptSlots >> kSlotNormal & 1u);
const uint kAtSheenColor = kAtWeight + (kKeptSlots >> kSlotWeight & 1u);
const uint kDerivativeCount = kAtSheenColor + 3u * (kKeptSlots >> kSlotSheenColor & 1u);
const uint kDerivativePlaces = kDerivativeCount > 0u ? kDerivativeCount : 1u; // no array is empty

#endif
