// What an optimisation needs from whatever makes its images: an image and its reverse-mode derivative, per view.
#pragma once

#include "base/byte_stream.h"
#include "render/first_vertices.h"
#include "render/renderer.h"

namespace cmpg {

class ImageModel {
  public:
    virtual ~ImageModel() = default;

    virtual std::size_t views() const = 0;
    virtual std::pair<int, int> size(std::size_t view) const = 0; // width, height in pixels
    // An image of `spp` samples in all, at least one in each half. `difference`: with how they differ from the images under the values of
    // setSecondValues().
    // `samples`: as in GuidedPasses::renderHalves().
    virtual ImageHalves renderHalves(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges& samples) = 0;
    virtual void setSecondValues(std::uint32_t parameter, std::span<const float> values) = 0;
    // How the next of these images are drawn, and what those so far tell of the variance of one sample by a method. 0: not known.
    virtual Sampling imageMethod() const { return Sampling::Bsdf; }
    virtual double imageVariance(Sampling /*method*/) const { return 0; }
    // An image to keep, which no later pass depends on. `difference`: drawn as the images of renderHalves() that have differences.
    virtual Image picture(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference) = 0;
    // Adds adjoint^T . dI/dp to `gradients`, one vector of entries() doubles per optimised parameter, in their order, from `spp` samples
    // per pixel on average. Returns how many samples there were.
    virtual std::uint64_t reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                  std::vector<std::vector<double>>& gradients) = 0;
    // As reverse(), of a gradient that is the mean of several such passes; once it is added to that of the views before, tellNoise() says how noisy the whole
    // of it is: `half` is half of how two halves of the passes differ, `sum` the gradient of all views so far.
    virtual std::uint64_t reversePart(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                      std::vector<std::vector<double>>& gradients) {
        return reverse(view, spp, key, adjoint, gradients);
    }
    virtual void tellNoise(const std::vector<std::vector<double>>& /*half*/, const std::vector<std::vector<double>>& /*sum*/) {}
    // As reverse(), but no later pass depends on it. Fills in `firstVertices`, if it is not null, where it knows them.
    virtual std::uint64_t reverseApart(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                       std::vector<std::vector<double>>& gradients, FirstVertices* /*firstVertices*/) {
        return reverse(view, spp, key, adjoint, gradients);
    }
    // As reverse(), in two halves of `spp` / 2 samples, one at least, with numbers of their own: adds their mean, and to `half` half of how they
    // differ.
    virtual std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                        std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>& half) = 0;
    // Of the last derivative pass: share of its few largest samples in the sum of all squares; 0 where it is not known.
    virtual double concentration() const { return 0; }
    virtual void setParameter(std::uint32_t parameter, std::span<const float> values) = 0;
    // After the passes of a step, before its update: the model may learn from them.
    virtual void endStep() {}
    // After the update, with all values set: what was learned reaches the passes to come.
    virtual void publish() {}
    // What was learned so far, `steps` steps: as the last step left it. restore() changes nothing where it throws Malformed or Error.
    virtual void save(ByteWriter&) const {}
    virtual void restore(ByteReader&, std::uint32_t /*steps*/) {}
};

} // namespace cmpg
