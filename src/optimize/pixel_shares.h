// Which pixels of a view get the samples of its images: those that answer to the parameters.
#pragma once

#include <cmpg/image.h>

#include <span>
#include <vector>

namespace cmpg {

// How the pixels of a view answer to a change of the parameters, summed over their channels and over all that was added.
class PixelAnswers {
  public:
    // Two halves of the change of an image, with random numbers of their own. `mask`: as in Target; pixels without weight have a share of 0.
    void add(const Image& a, const Image& b, std::span<const float> mask = {});
    // OptimizeState::pixelShares: the root of the products of both halves around a pixel, in which no path has a part that is in one of them by chance. Where only
    // rare paths find the light, the halves agree on next to nothing, and what they agree on tells of chance again: as much of the samples as is not known goes to
    // all pixels alike, but for those without weight. Empty where nothing answers.
    std::vector<float> shares(int width, int height) const;

  private:
    bool isMasked(std::size_t pixel) const { return !masked_.empty() && masked_[pixel]; }

    std::vector<float> product_, square_; // of both halves, and the mean of each alone
    std::vector<bool> masked_;            // pixels without weight; empty: none
};

} // namespace cmpg
