// Passes in two halves with random numbers of their own, and the results of passes as lists of numbers.
#pragma once

#include "render/pass_plan.h"
#include "scene/image.h"

#include <vector>

namespace cmpg {

PassKey secondHalf(const PassKey& key);

// Of a pass in two halves: paths and rays of both, what it measured on average.
PassResult meanOf(PassResult a, const PassResult& b);

// sum[p][i] += (a[p][i] + sign b[p][i]) / 2
void addHalf(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b, double sign, std::vector<std::vector<double>>& sum);

// Of an image: their squares add up to means over the channels, as PassResult::variance does.
std::vector<double> entries(const Image& image);
std::vector<double> entries(const std::vector<std::vector<double>>& gradients);

} // namespace cmpg
