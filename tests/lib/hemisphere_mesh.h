// A partition of the hemisphere that is finer towards one direction, with quadrature: bins and integrals for narrow lobes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <vector>

namespace cmpg::test {

// Cells are rectangles in (rho, phi) with rho^2 = 1 - cos(theta) about +z, an equal-area map: the horizon is the edge rho = 1.
// phi is measured from the peak's. Cells double in size with each step away from the peak.
class HemisphereMesh {
  public:
    HemisphereMesh(const glm::dvec3& peak, double finestRho, double finestPhi)
        : peakPhi_(std::atan2(peak.y, peak.x)), rho_(graded(std::sqrt(std::max(1 - peak.z, 0.0)), 0, 1, finestRho, 0.125)),
          phi_(graded(0, -glm::pi<double>(), glm::pi<double>(), finestPhi, glm::pi<double>() / 8)) {}

    std::size_t cells() const { return (rho_.size() - 1) * (phi_.size() - 1); }

    std::size_t cellOf(const glm::dvec3& direction) const {
        const double phi = std::remainder(std::atan2(direction.y, direction.x) - peakPhi_, 2 * glm::pi<double>());
        const double rho = std::hypot(direction.x, direction.y) / std::sqrt(1 + direction.z); // accurate at the pole
        return interval(rho_, rho) * (phi_.size() - 1) + interval(phi_, phi);
    }

    // The integral over the solid angle of every cell, by 8 x 8 Gauss points.
    std::vector<double> integrate(const std::function<double(const glm::dvec3&)>& f) const {
        static constexpr std::array<double, 4> x{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
        static constexpr std::array<double, 4> w{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
        const auto point = [](const std::vector<double>& edges, std::size_t i, int k) {
            return 0.5 * (edges[i] + edges[i + 1] + (k < 4 ? x[k] : -x[k - 4]) * (edges[i + 1] - edges[i]));
        };
        std::vector<double> result;
        for (std::size_t i = 0; i + 1 < rho_.size(); ++i) {
            for (std::size_t j = 0; j + 1 < phi_.size(); ++j) {
                double sum = 0;
                for (int k = 0; k < 64; ++k) {
                    const double rho = point(rho_, i, k / 8), phi = peakPhi_ + point(phi_, j, k % 8);
                    const double z = 1 - rho * rho, r = rho * std::sqrt(1 + z);
                    sum += w[k / 8 % 4] * w[k % 4] * 2 * rho * f({r * std::cos(phi), r * std::sin(phi), z});
                }
                result.push_back(sum * 0.25 * (rho_[i + 1] - rho_[i]) * (phi_[j + 1] - phi_[j]));
            }
        }
        return result;
    }

  private:
    static std::vector<double> graded(double center, double low, double high, double finest, double coarsest) {
        std::vector<double> edges{low, high};
        if (center > low && center < high) edges.push_back(center);
        for (double distance = finest; distance < high - low; distance += std::clamp(distance, finest, coarsest)) {
            if (center - distance > low) edges.push_back(center - distance);
            if (center + distance < high) edges.push_back(center + distance);
        }
        std::sort(edges.begin(), edges.end());
        return edges;
    }

    static std::size_t interval(const std::vector<double>& edges, double x) {
        const auto above = std::upper_bound(edges.begin() + 1, edges.end() - 1, x);
        return static_cast<std::size_t>(above - edges.begin()) - 1;
    }

    double peakPhi_;
    std::vector<double> rho_, phi_;
};

} // namespace cmpg::test
