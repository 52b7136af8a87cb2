// The curvature of the loss by texels that cameras see directly.
#include "optimize/seen_texels.h"

#include "base/parallel.h"
#include "scene/texel_lookup.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmpg {
namespace {

constexpr std::size_t kRowsAtOnce = 1024;

using Share = std::pair<std::uint32_t, float>; // texel, and how much of it a pixel sees

// What two rays see of the same texels.
float overlap(const TexelLookup& a, const TexelLookup& b) {
    float sum = 0;
    for (std::size_t k = 0; k < a.texel.size(); ++k)
        for (std::size_t l = 0; l < b.texel.size(); ++l)
            sum += a.texel[k] == b.texel[l] ? a.weight[k] * b.weight[l] : 0;
    return sum;
}

// Of the texels that the rays of a pixel met, each once. Returns the mean, over the rays, of the overlap of each with itself.
float sharesOf(const Parameter& parameter, const std::vector<bool>& owners, std::span<const FirstVertex> rays, std::vector<Share>& shares) {
    shares.clear();
    float own = 0;
    for (const FirstVertex& ray : rays) {
        if (ray.material == kNoMaterial || !owners[ray.material])
            continue;
        const TexelLookup found = lookUp(parameter, ray.uv0, ray.uv1);
        for (std::size_t k = 0; k < found.texel.size(); ++k)
            if (found.weight[k] > 0)
                shares.emplace_back(found.texel[k], found.weight[k] / float(rays.size()));
        own += overlap(found, found);
    }
    std::sort(shares.begin(), shares.end());
    std::size_t last = 0;
    for (std::size_t i = 1; i < shares.size(); ++i)
        if (shares[i].first == shares[last].first)
            shares[last].second += shares[i].second;
        else
            shares[++last] = shares[i];
    shares.resize(std::min(shares.size(), last + 1));
    return own / float(std::max<std::size_t>(1, rays.size()));
}

// Of a pixel. Squares of its true shares F and of those that its rays tell, f: |F|^2, as often as pairs of rays overlap, and |f|^2.
struct Sight {
    float cover = 0; // the square of how much of the pixel the texture covers
    float common = 0, found = 0;
};

} // namespace

void SeenTexels::add(const Parameter& parameter, const std::vector<bool>& owners, const FirstVertices& first, const Image& curvature, std::span<const float> noise) {
    texels_ = std::size_t(parameter.width) * parameter.height;
    channels_ = parameter.channels;
    const std::size_t pixels = curvature.pixels();
    std::vector<Sight> sights(pixels);
    std::vector<std::size_t> seen; // pixels with a row
    std::vector<Share> shares;
    for (std::size_t p = 0; p < pixels; ++p) {
        const std::size_t rays = first.begin[p + 1] - first.begin[p];
        const float own = sharesOf(parameter, owners, std::span(first.vertices).subspan(first.begin[p], rays), shares);
        if (shares.empty())
            continue;
        if (pixelShares_.size() + shares.size() > kMostShares) {
            whole_ = false;
            break;
        }
        float cover = 0;
        Sight& sight = sights[p];
        for (const auto& [texel, share] : shares) {
            pixelShares_.column.push_back(texel);
            pixelShares_.share.push_back(share);
            cover += share;
            sight.found += share * share;
        }
        pixelShares_.begin.push_back(std::uint32_t(pixelShares_.size()));
        sight.cover = cover * cover;
        if (rays > 1)
            sight.common = std::max(0.f, sight.found - own / float(rays)) * float(rays) / float(rays - 1);
        seen.push_back(p);
    }
    for (const std::size_t p : seen) {
        const int x = int(p % std::size_t(curvature.width)), y = int(p / std::size_t(curvature.width));
        double sum[3] = {}, cover = 0, common = 0, all = 0;
        for (int v = std::max(0, y - 1); v <= std::min(curvature.height - 1, y + 1); ++v)
            for (int u = std::max(0, x - 1); u <= std::min(curvature.width - 1, x + 1); ++u) {
                const std::size_t at = std::size_t(v) * std::size_t(curvature.width) + std::size_t(u);
                if (sights[at].cover == 0)
                    continue;
                cover += sights[at].cover;
                common += sights[at].common;
                all += sights[at].found;
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c] += curvature.values[3 * at + c];
            }
        if (channels_ == 1)
            sum[0] += sum[1] + sum[2]; // one number brightens or darkens all three
        for (std::size_t c = 0; c < channels_; ++c) {
            const double found = sum[c] / cover;
            curvature_.push_back(found > 0 && std::isfinite(float(found)) ? float(found) : 0.f);
        }
        noise_.push_back(noise.empty() || !std::isfinite(noise[p]) ? 0.f : noise[p]);
        known_.push_back(all > 0 ? float(std::clamp(2 * common / all - 1, 0.0, 1.0)) : 0.f);
    }
}

void SeenTexels::finish() {
    texelShares_ = {};
    texelShares_.begin.assign(texels_ + 1, 0);
    for (const std::uint32_t texel : pixelShares_.column)
        ++texelShares_.begin[texel + 1];
    for (std::size_t t = 0; t < texels_; ++t)
        texelShares_.begin[t + 1] += texelShares_.begin[t];
    std::vector<std::uint32_t> next(texelShares_.begin.begin(), texelShares_.begin.end() - 1);
    texelShares_.column.resize(pixelShares_.size());
    texelShares_.share.resize(pixelShares_.size());
    for (std::size_t row = 0; row < pixelShares_.rows(); ++row)
        for (std::uint32_t k = pixelShares_.begin[row]; k < pixelShares_.begin[row + 1]; ++k) {
            const std::uint32_t at = next[pixelShares_.column[k]]++;
            texelShares_.column[at] = std::uint32_t(row);
            texelShares_.share[at] = pixelShares_.share[k];
        }
    findLight();
    const std::size_t entries = texels_ * channels_;
    told_.assign(entries, 0);
    const std::vector<float> ones(entries, 1.f);
    addMultiply(ones, 1, {}, told_);
    rows_.assign(entries, 0);
    addMultiply(ones, 1, rows_);
    diagonal_.assign(entries, 0);
    for (std::size_t t = 0; t < texels_; ++t)
        for (std::uint32_t k = texelShares_.begin[t]; k < texelShares_.begin[t + 1]; ++k)
            for (std::size_t c = 0; c < channels_; ++c)
                diagonal_[t * channels_ + c] +=
                    texelShares_.share[k] * texelShares_.share[k] * known_[texelShares_.column[k]] * curvature_[texelShares_.column[k] * channels_ + c];
}

void SeenTexels::findLight() {
    std::vector<double> answers(pixelShares_.rows()), cover(pixelShares_.rows());
    double answer = 0, noise = 0, weights = 0; // sums
    for (std::size_t row = 0; row < pixelShares_.rows(); ++row) {
        for (std::size_t c = 0; c < channels_; ++c)
            answers[row] += curvature_[row * channels_ + c];
        for (std::uint32_t k = pixelShares_.begin[row]; k < pixelShares_.begin[row + 1]; ++k)
            cover[row] += pixelShares_.share[k];
        answer += cover[row] * answers[row];
        noise += cover[row] * noise_[row];
        weights += cover[row];
    }
    const auto beside = [&](double value, double sum) { return sum > 0 ? value * weights / sum : 0; };
    light_.assign(texels_, -1.f);
    for (std::size_t t = 0; t < texels_; ++t) {
        double own = 0, weight = 0;
        for (std::uint32_t k = texelShares_.begin[t]; k < texelShares_.begin[t + 1]; ++k) {
            const std::uint32_t row = texelShares_.column[k];
            own += texelShares_.share[k] * std::max(beside(answers[row], answer), beside(noise_[row], noise));
            weight += texelShares_.share[k];
        }
        if (weight > 0)
            light_[t] = float(own / weight);
    }
}

void SeenTexels::addMultiply(std::span<const float> x, float part, std::span<float> out) const { addMultiply(x, part, known_, out); }

void SeenTexels::addMultiply(std::span<const float> x, float part, std::span<const float> known, std::span<float> out) const {
    const std::size_t channels = channels_;
    std::vector<float> y(curvature_.size());
    // to[row] += factor * sum_k share * from[column], of all channels.
    const auto multiply = [channels](const Shares& matrix, std::span<const float> from, const auto& store) {
        parallelFor(matrix.rows(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                float sum[3] = {};
                for (std::uint32_t k = matrix.begin[row]; k < matrix.begin[row + 1]; ++k) {
                    const float* entry = from.data() + matrix.column[k] * channels;
                    for (std::size_t c = 0; c < channels; ++c)
                        sum[c] += matrix.share[k] * entry[c];
                }
                for (std::size_t c = 0; c < channels; ++c)
                    store(row * channels + c, sum[c]);
            }
        });
    };
    multiply(pixelShares_, x, [&](std::size_t i, float sum) { y[i] = curvature_[i] * (known.empty() ? 1 : known[i / channels]) * sum; });
    multiply(texelShares_, y, [&](std::size_t i, float sum) { out[i] += part * sum; });
}

void SeenTexels::save(ByteWriter& out) const {
    out.put(std::uint8_t(whole_));
    out.count(texels_);
    out.count(channels_);
    out.count(pixelShares_.rows());
    for (std::size_t row = 0; row < pixelShares_.rows(); ++row)
        out.put(pixelShares_.begin[row + 1] - pixelShares_.begin[row]);
    for (const std::uint32_t texel : pixelShares_.column)
        out.put(texel);
    out.put(pixelShares_.share);
    out.put(curvature_);
    out.put(known_);
    out.put(noise_);
}

void SeenTexels::restore(ByteReader& in, std::size_t entries) {
    const auto figures = [](const std::vector<float>& values) { return std::all_of(values.begin(), values.end(), [](float v) { return v >= 0 && std::isfinite(v); }); };
    const bool whole = in.get<std::uint8_t>() != 0;
    const auto texels = in.get<std::uint64_t>(), channels = in.get<std::uint64_t>();
    if (channels < 1 || channels > 3 || texels > entries / channels)
        throw Malformed{"the texels that cameras see are of another texture"};
    Shares shares;
    std::uint64_t total = 0;
    for (std::size_t row = in.count(4); row > 0; --row) {
        total += in.get<std::uint32_t>();
        if (total > kMostShares)
            throw Malformed{"cameras see more texels than are kept"};
        shares.begin.push_back(std::uint32_t(total));
    }
    for (; total > 0; --total) {
        shares.column.push_back(in.get<std::uint32_t>());
        if (shares.column.back() >= texels)
            throw Malformed{"cameras see a texel beyond the texture"};
    }
    shares.share = in.reals<float>();
    std::vector<float> curvature = in.reals<float>(), known = in.reals<float>(), noise = in.reals<float>();
    if (shares.share.size() != shares.column.size() || curvature.size() != shares.rows() * channels || known.size() != shares.rows() ||
        noise.size() != shares.rows() || !figures(shares.share) || !figures(curvature) || !figures(known) || !figures(noise))
        throw Malformed{"the curvature by texels that cameras see does not fit"};
    whole_ = whole;
    texels_ = std::size_t(texels);
    channels_ = std::size_t(channels);
    pixelShares_ = std::move(shares);
    curvature_ = std::move(curvature);
    known_ = std::move(known);
    noise_ = std::move(noise);
    finish();
}

} // namespace cmpg
