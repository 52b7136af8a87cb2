// The curvature of the loss by texels that cameras see directly.
#pragma once

#include "base/byte_stream.h"
#include "optimize/coarse_texture.h"
#include "render/first_vertices.h"
#include "scene/image.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace cmpg {

// A pixel sees several texels at once where they are finer than it, or at a slant. A diagonal that bounds their curvature (CurvatureDirection) lets what tells
// them apart arrive in many steps. What a pixel sees directly is known: row f_p has the share of each texel in it, told by its camera rays, and the loss
// curves by c_p, of each channel, with all that it sees of the texture: together C_c = sum_p k_p c_p f_p^T f_p of texels, for each channel.
// A few rays do not tell the true shares F_p of many texels. The rays of other passes meet others, to which C gives no curvature, and steps would diverge. So
// k_p = 2 |F_p|^2 / |f_p|^2 - 1, from 0 to 1. |F_p|^2 is how often two rays of the pixel see the same; m = |f_p - F_p|^2 / |F_p|^2 is |f_p|^2 / |F_p|^2 - 1 on
// average. The diagonal keeps 1 - k_p of the row. It bounds what f_p misses, where m < 1 - k_p; k_p is (1 - m) / (1 + m).
class SeenTexels {
  public:
    // Adds what a view sees of a texture, up to kMostShares of all views: of the others the diagonal tells, and isWhole() no longer holds. Of `parameter` its
    // size counts, and how points find texels. `owners`: by material of the scene, whether the parameter is its own. `curvature`: by pixel and channel, that of the loss by all texels together. It is noisy, as k is, and what is seen of the
    // texture is lit evenly: 3 x 3 pixels share theirs. `noise`: by pixel, of the image, in the unit of the loss; empty: none.
    void add(const Parameter& parameter, const std::vector<bool>& owners, const FirstVertices& first, const Image& curvature, std::span<const float> noise = {});
    // After the last view.
    void finish();

    bool empty() const { return pixelShares_.size() == 0; }
    bool isWhole() const { return whole_; } // all that the views see
    bool fits(const TextureGrid& grid) const { return texels_ == grid.width * grid.height && channels_ == grid.channels; }
    // By entry: the sums of C's rows; its diagonal.
    std::span<const float> rows() const { return rows_; }
    std::span<const float> diagonal() const { return diagonal_; }
    // By texel, of the pixels that see it: how bright they are lit, by how they answer to it, or how noisy they are, whichever is more beside the mean of all that
    // see the texture; squares of light both. Negative where none does.
    std::span<const float> light() const { return light_; }
    std::span<const float> told() const { return told_; } // the sums of rows if all k_p were 1: what views tell of an entry
    // out += part C x. entries() each.
    void addMultiply(std::span<const float> x, float part, std::span<float> out) const;

    void save(ByteWriter& out) const;
    void restore(ByteReader& in, std::size_t entries); // of the parameter, at most; throws Malformed

    static constexpr std::size_t kMostShares = std::size_t(1) << 22; // 64 MiB with what lists them by texel

  private:
    // A sparse matrix by rows.
    struct Shares {
        std::vector<std::uint32_t> begin{0}, column;
        std::vector<float> share;
        std::size_t rows() const { return begin.size() - 1; }
        std::size_t size() const { return share.size(); }
    };

    void findLight();
    // `known`: k by row; all 1 where empty.
    void addMultiply(std::span<const float> x, float part, std::span<const float> known, std::span<float> out) const;

    bool whole_ = true;
    std::size_t texels_ = 0, channels_ = 0;
    Shares pixelShares_, texelShares_; // f, f^T
    std::vector<float> curvature_;     // c, by row of f and channel
    std::vector<float> known_;         // k, by row of f
    std::vector<float> noise_;         // of the image, by row of f
    std::vector<float> rows_, diagonal_, told_, light_;
};

} // namespace cmpg
