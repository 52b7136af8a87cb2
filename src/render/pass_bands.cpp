// The pixels of a pass, dealt to the ranks that share it.
#include "render/pass_bands.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace cmpg {
namespace {

// Of a band at least: smaller batches cost more in submissions than they gain in balance. At most so many bands a rank.
constexpr std::uint64_t kBandSamples = 1 << 15, kMostBands = 8;

template <class T> void shareBands(std::vector<T>& pixels, Communicator& ranks, std::span<const PixelBand> bands) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<std::size_t> sizes(std::size_t(ranks.size()));
    std::vector<std::byte> own;
    for (const PixelBand& band : bands) {
        const auto bytes = std::as_bytes(std::span(pixels).subspan(band.begin, band.end - band.begin));
        sizes[std::size_t(band.rank)] += bytes.size();
        if (band.rank == ranks.rank())
            own.insert(own.end(), bytes.begin(), bytes.end());
    }
    const std::vector<std::byte> all = ranks.gather(own, sizes);
    std::vector<std::size_t> at(sizes.size());
    for (std::size_t r = 1; r < at.size(); ++r)
        at[r] = at[r - 1] + sizes[r - 1];
    for (const PixelBand& band : bands) {
        const auto bytes = std::as_writable_bytes(std::span(pixels).subspan(band.begin, band.end - band.begin));
        std::memcpy(bytes.data(), all.data() + at[std::size_t(band.rank)], bytes.size());
        at[std::size_t(band.rank)] += bytes.size();
    }
}

} // namespace

std::vector<PixelBand> pixelBands(const PassInput& in, int ranks) {
    const std::size_t pixels = std::size_t(in.width) * in.height;
    if (ranks == 1)
        return {{0, pixels, 0}};
    std::uint64_t samples = 0;
    for (std::size_t p = 0; p < pixels; ++p)
        samples += in.samples(p);
    const std::uint64_t each = std::clamp<std::uint64_t>(samples / (std::uint64_t(ranks) * kBandSamples), 1, kMostBands);
    const std::uint64_t count = each * std::uint64_t(ranks);
    std::vector<PixelBand> bands;
    std::uint64_t passed = 0;
    std::size_t pixel = 0;
    for (std::uint64_t b = 0; b < count; ++b) {
        PixelBand band{pixel, pixel, int(b % std::uint64_t(ranks))};
        while (pixel < pixels && (b + 1 == count || passed * count < (b + 1) * samples))
            passed += in.samples(pixel++);
        band.end = pixel;
        bands.push_back(band);
    }
    return bands;
}

void shareFirstVertices(FirstVertices& first, Communicator& ranks, std::span<const PixelBand> bands) {
    std::vector<PixelBand> paths; // the same bands, of camera rays
    for (const PixelBand& band : bands)
        paths.push_back({first.begin[band.begin], first.begin[band.end], band.rank});
    shareBands(first.vertices, ranks, paths);
}

BandFilm::BandFilm(std::size_t pixels, bool differences, bool layers)
    : film_(pixels), difference_(differences ? pixels : 0), layers_(layers ? pixels : 0) {}

void BandFilm::set(std::size_t pixel, const Gathered& gathered) {
    film_[pixel] = gathered.film;
    if (!difference_.empty())
        difference_[pixel] = gathered.difference;
    if (!layers_.empty())
        layers_[pixel] = gathered.layers;
}

Gathered BandFilm::get(std::size_t pixel) const {
    return {film_[pixel], difference_.empty() ? gpu::FilmPixel{} : difference_[pixel], layers_.empty() ? gpu::LayerSample{} : layers_[pixel]};
}

void BandFilm::share(Communicator& ranks, std::span<const PixelBand> bands) {
    shareBands(film_, ranks, bands);
    if (!difference_.empty())
        shareBands(difference_, ranks, bands);
    if (!layers_.empty())
        shareBands(layers_, ranks, bands);
}

} // namespace cmpg
