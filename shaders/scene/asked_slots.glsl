#ifndef CMPG_SCENE_ASKED_SLOTS
#define CMPG_SCENE_ASKED_SLOTS
// A bit for each slot of the material that is differentiated, and perhaps for emission. That of anisotropy has none in the flags: its GpuSlot tells.
uint askedSlots(uint material, uint flags) {
    uint asked = flags >> kDifferentiatedShift & ((1u << kFlaggedSlots) - 1u);
    if (kDiffAnisotropy && (flags & kMaterialAnisotropic) != 0) {
        const uint gradient = slotTexel((material * kSlotsPerMaterial + kSlotAnisotropy) * kSlotTexels + 2).z;
        asked |= gradient == kNone ? 0u : 1u << kSlotAnisotropy;
    }
    return asked;
}

#endif
