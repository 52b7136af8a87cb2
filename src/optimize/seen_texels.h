// The curvature of the loss by texels that cameras see directly.
#pragma once

#include "base/byte_stream.h"
#include "render/first_vertices.h"
#include "scene/image.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace cmpg {

// A pixel sees several texels at once where they are finer than it, or at a slant. A diagonal that bounds their curvature (CurvatureDirection) lets what tells
// them apart arrive in many steps. What a pixel sees directly is known: row F_p has the share of each texel in it, told by its camera rays, and the loss
// curves by c_p, of each channel, with all that it sees of the texture: together C_c = sum_p c_p F_p^T F_p of texels, for each channel.
class SeenTexels {
  public:
    // Adds what a view sees of a texture, up to kMostShares of all views: of the others the diagonal tells, and isWhole() no longer holds. `owners`: by material of the scene, whether the
    // parameter is its own. `curvature`: by pixel and channel, that of the loss by all texels together. It is noisy, and what is seen of the
    // texture is lit evenly: 3 x 3 pixels share theirs.
    void add(const Parameter& parameter, const std::vector<bool>& owners, const FirstVertices& first, const Image& curvature);
    // After the last view.
    void finish();

    bool empty() const { return pixelShares_.size() == 0; }
    bool isWhole() const { return whole_; } // all that the views see
    bool fits(const Parameter& parameter) const { return texels_ == std::size_t(parameter.width) * parameter.height && channels_ == parameter.channels; }
    // By entry: the sums of C's rows; its diagonal.
    std::span<const float> rows() const { return rows_; }
    std::span<const float> diagonal() const { return diagonal_; }
    // out += part C x. entries() each.
    void addMultiply(std::span<const float> x, float part, std::span<float> out) const;

    void save(ByteWriter& out) const;
    void restore(ByteReader& in, std::size_t entries); // of the parameter; throws Malformed

    static constexpr std::size_t kMostShares = std::size_t(1) << 22; // 64 MiB with what lists them by texel

  private:
    // A sparse matrix by rows.
    struct Shares {
        std::vector<std::uint32_t> begin{0}, column;
        std::vector<float> share;
        std::size_t rows() const { return begin.size() - 1; }
        std::size_t size() const { return share.size(); }
    };

    bool whole_ = true;
    std::size_t texels_ = 0, channels_ = 0;
    Shares pixelShares_, texelShares_; // F, F^T
    std::vector<float> curvature_;     // c, by row of F and channel
    std::vector<float> rows_, diagonal_;
};

} // namespace cmpg
