// The pixels of a pass, dealt to the ranks that share it.
#pragma once

#include "base/communicator.h"
#include "render/pass_batches.h"
#include "render/pass_runner.h"
#include "shared/film.h"

namespace cmpg {

// Consecutive pixels [begin, end), which one rank takes.
struct PixelBand {
    std::size_t begin = 0, end = 0;
    int rank = 0;
};

// All pixels in order, in bands of about equally many samples, dealt in turn: what is costly in an image lies together, so each rank has several.
// One band where there is one rank.
std::vector<PixelBand> pixelBands(const PassInput& in, int ranks);

// Of bands that each rank has filled in for itself: every rank has all afterwards.
void shareFirstVertices(FirstVertices& first, Communicator& ranks, std::span<const PixelBand> bands);

// What the ranks gathered in their bands, by pixel.
class BandFilm {
  public:
    BandFilm(std::size_t pixels, bool differences, bool layers);
    void set(std::size_t pixel, const Gathered& gathered);
    Gathered get(std::size_t pixel) const;
    // Every rank has all pixels afterwards.
    void share(Communicator& ranks, std::span<const PixelBand> bands);

  private:
    std::vector<gpu::FilmPixel> film_, difference_;
    std::vector<gpu::LayerSample> layers_;
};

} // namespace cmpg
