// What a vertex tells the guide: the light that came from its drawn direction and the derivatives that did, without what light sampling
// covers (its MIS weight is in the emission already). Expects scene/integer_sums.glsl, statistics[].
#include "shared/guide.h"
layout(binding = kBindGuideInfo, scalar) uniform GuideInfoBlock { GuideInfo guide; };
QUEUE_UINT(visitWord, kBindGuideVisits)

layout(binding = kBindGuideLeafSums, scalar) buffer GuideLeaves { GuideLeafSums leafSums[]; };
layout(binding = kBindGuideCellSums, scalar) buffer GuideCells { GuideCellSums cellSums[]; };

// A record is a mean over the channels; one that does not fit, or is no number, is left out and counted.
#define ADD_RECORD(sum, value, scale) \
    { \
        const float mean_ = dot(value, vec3(1.0 / 3.0)); \
        uvec2 words_; \
        if (!(mean_ <= 0.0)) { \
            if (toFixedPoint(mean_ * scale.x, scale.y, words_) && words_.y < 0x00400000u) { \
                uint before_; \
                ADD_INTEGER(sum, words_, before_) \
            } else { \
                atomicAdd(statistics[kSaturatedRecord], 1); \
            } \
        } \
    }
