// Passes of an estimate in batches.
#include "optimize/batch_parts.h"

#include <algorithm>

namespace cmpg {

PassKey partKey(const PassKey& key, const BatchPart& part, std::uint32_t batches, bool continues) {
    constexpr std::uint32_t kPasses = 16; // that one batch may have of its own, see PassKey::pass
    PassKey own = key;
    own.pass += kPasses * (1 + part.batch + (continues ? 0 : batches * part.stage));
    own.firstSample = continues ? part.firstSample : 0;
    return own;
}

Image toImage(const std::vector<double>& values, int width, int height) {
    Image image(width, height, 3);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = float(values[i]);
    return image;
}

std::vector<double> fromImage(const Image& image) { return {image.values.begin(), image.values.end()}; }

std::vector<double> joined(const std::vector<std::vector<double>>& gradients) {
    std::vector<double> values;
    for (const auto& gradient : gradients)
        values.insert(values.end(), gradient.begin(), gradient.end());
    return values;
}

void divide(std::span<const double> values, std::vector<std::vector<double>>& gradients) {
    for (auto& gradient : gradients) {
        std::copy_n(values.begin(), gradient.size(), gradient.begin());
        values = values.subspan(gradient.size());
    }
}

} // namespace cmpg
