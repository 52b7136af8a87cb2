// How far an image is off its target: what is tolerated, what its noise explains, and what is left. The weight of the prior follows from it, and how many
// samples an image gets.
#pragma once

#include "optimize/running_image.h"
#include "optimize/target.h"

#include <cmpg/options.h>

#include <limits>
#include <optional>
#include <span>

namespace cmpg {

// The loss of an image that is wrong by a tenth of the target's mean everywhere. Of the mean, not the root mean square: a lamp in the picture would
// make that large, and all that the lamp lights would be trusted little.
double toleratedLoss(Loss loss, const Target& target);

// The loss where an image answers to the parameters.
struct Residual {
    double whole = 0;  // of the image as it is
    double beyond = 0; // of a squared loss without the image's noise, in expectation: the target's noise, and values that are still on their way
};

// `shares`: by pixel, how strongly it answers (OptimizeState::pixelShares), or empty for all alike. Pixels whose error is larger than `most` weigh less, by as
// much as it is larger. Nothing where no pixel answers.
std::optional<Residual> residual(Loss loss, const RunningImage& image, const Target& target, std::span<const float> shares,
                                 double most = std::numeric_limits<double>::infinity());

// What a prior of textures weighs beside an image.
struct ExpectedLoss {
    double noise = 0;     // of a squared loss: what the image's noise explains
    double beyond = 0;    // what it does not
    double tolerated = 0; // the error is this at most
    // As likely as the errors of the image are, for a texture of which a pixel sees so many texels along its edge (0: not known). Of
    // texels smaller than a pixel an image tells the differences least, and its noise counts more; larger ones are means over several
    // pixels, and it counts less. An edge of what fine textures show is as many differences of texels longer as they are finer, and the
    // image tells no more of it.
    double beside(double texelsPerPixel) const;
};
constexpr double kTexelsOfPrior = 3; // along the edge of a pixel: the prior of finer textures weighs as much less as they are finer

// As likely as the errors of an image are: those that its noise explains, and those beyond it. Values that fit noise lower the second part, not
// the first. Twice the mean square, of a squared loss: exp(-n loss / expected) is a normal distribution then; the mean of the others, for a Laplace distribution.
// An error of a pixel far above `tolerated` tells little: it is the edge
// of a lamp in the picture, or a path that met the lamp by chance, and says nothing of what is known elsewhere. The error is at most `tolerated`, since an image
// may be off because values are. `tolerated` where no pixel answers.
ExpectedLoss expectedLoss(Loss loss, const RunningImage& image, const Target& target, std::span<const float> shares, double tolerated);

} // namespace cmpg
