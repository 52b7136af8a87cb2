#ifndef CMPG_SCENE_ASKED_SLOTS
#define CMPG_SCENE_ASKED_SLOTS
// The slot's bit, if its GpuSlot says that it is differentiated.
uint askedBySlot(uint material, uint slot) {
    const uint gradient = slotTexel((material * kSlotsPerMaterial + slot) * kSlotTexels + 2).z;
    return gradient == kNone ? 0u : 1u << slot;
}

// A bit for each slot of the material that is differentiated, and perhaps for emission. Those of anisotropy and sheen have none in the flags.
uint askedSlots(uint material, uint flags) {
    uint asked = flags >> kDifferentiatedShift & ((1u << kFlaggedSlots) - 1u);
    if (kDiffAnisotropy && (flags & kMaterialAnisotropic) != 0) asked |= askedBySlot(material, kSlotAnisotropy);
    if (kDiffSheenRoughness && (flags & kMaterialSheen) != 0) asked |= askedBySlot(material, kSlotSheenRoughness);
    if (kDiffSheenColor && (flags & kMaterialSheen) != 0) asked |= askedBySlot(material, kSlotSheenColor);
    return asked;
}

#endif
