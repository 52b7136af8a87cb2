// One exposure for pictures that are to be compared.
#include "imaging/exposure.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

float exposureFor(const std::vector<const Image*>& images) {
    std::vector<float> values;
    for (const Image* image : images)
        for (const float v : image->values)
            if (std::isfinite(v))
                values.push_back(v);
    if (values.empty())
        return 1;
    const auto place = values.begin() + std::ptrdiff_t(0.95 * double(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place > 1 || (*place > 0 && *place < 0.5f) ? 1 / *place : 1;
}

} // namespace cmpg
