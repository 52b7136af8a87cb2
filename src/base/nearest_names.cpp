// Names by their distance to a mistyped one.
#include "base/nearest_names.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cmpg {

std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

std::vector<std::string> nearestNames(std::vector<std::string> names, const std::string& name, std::size_t most) {
    std::vector<std::pair<std::size_t, std::size_t>> order; // distance, place
    order.reserve(names.size());
    for (std::size_t i = 0; i < names.size(); ++i)
        order.emplace_back(editDistance(names[i], name), i);
    std::sort(order.begin(), order.end());
    std::vector<std::string> nearest;
    for (std::size_t i = 0; i < std::min(order.size(), most); ++i)
        nearest.push_back(std::move(names[order[i].second]));
    return nearest;
}

std::string likelyMeant(std::vector<std::string> names, const std::string& name) {
    const std::vector<std::string> near = nearestNames(std::move(names), name, 1);
    return !near.empty() && 3 * editDistance(near.front(), name) <= name.size() ? near.front() : std::string();
}

std::string didYouMean(std::vector<std::string> names, const std::string& name) {
    const std::string meant = likelyMeant(std::move(names), name);
    return meant.empty() ? "" : "did you mean " + meant + "? ";
}

} // namespace cmpg
