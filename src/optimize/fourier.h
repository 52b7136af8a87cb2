// Discrete Fourier transforms of a plane of complex numbers.
#pragma once

#include <cstddef>
#include <vector>

namespace cmpg {

// Real and imaginary parts stand apart, and a transform goes through all columns at once, so that its loops are vectorised.
class FourierPlane {
  public:
    FourierPlane(std::size_t width, std::size_t height); // powers of two; all zero
    // Afterwards the plane is transposed: width and height change places. The inverse brings it back, without the factor of 1 / (width height).
    void transform();
    void invert();

    std::size_t width() const { return width_; }
    std::vector<float> real, imaginary; // by row

  private:
    void alongColumns();
    void transpose(std::vector<float>& values);

    std::size_t width_, height_;
    std::vector<float> other_, otherImaginary_;
};

} // namespace cmpg
