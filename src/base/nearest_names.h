// Names that a mistyped one may stand for.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace cmpg {

// Levenshtein distance: how many letters have to be put in, left out or replaced.
std::size_t editDistance(const std::string& a, const std::string& b);

// The `most` of them nearest to `name`, the nearest first; those as near as each other keep their order.
std::vector<std::string> nearestNames(std::vector<std::string> names, const std::string& name, std::size_t most);

// The nearest, if at most a third of the letters of `name` are wrong: else it would be a guess. Empty: none.
std::string likelyMeant(std::vector<std::string> names, const std::string& name);
// The same as the beginning of a remedy: "did you mean ...? ", or nothing.
std::string didYouMean(std::vector<std::string> names, const std::string& name);

} // namespace cmpg
