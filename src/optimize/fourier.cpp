// Discrete Fourier transforms of a plane of complex numbers.
#include "optimize/fourier.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace cmpg {

FourierPlane::FourierPlane(std::size_t width, std::size_t height)
    : real(width * height), imaginary(width * height), width_(width), height_(height), other_(width * height), otherImaginary_(width * height) {}

// Stockham's order, which needs no bits reversed: rows k + j m and k + j m + l m become k + 2 j m and k + 2 j m + m.
void FourierPlane::alongColumns() {
    for (std::size_t l = height_ / 2, m = 1; l > 0; l /= 2, m *= 2) {
        for (std::size_t j = 0; j < l; ++j) {
            const std::complex<double> turn = std::polar(1.0, -std::numbers::pi * double(j) / double(l));
            const auto cosine = float(turn.real()), sine = float(turn.imag());
            for (std::size_t k = 0; k < m; ++k) {
                const std::size_t first = (k + j * m) * width_, second = first + l * m * width_, sum = (k + 2 * j * m) * width_, difference = sum + m * width_;
                for (std::size_t x = 0; x < width_; ++x) {
                    const float a = real[first + x], b = imaginary[first + x], c = real[second + x], d = imaginary[second + x];
                    other_[sum + x] = a + c;
                    otherImaginary_[sum + x] = b + d;
                    other_[difference + x] = cosine * (a - c) - sine * (b - d);
                    otherImaginary_[difference + x] = cosine * (b - d) + sine * (a - c);
                }
            }
        }
        std::swap(real, other_);
        std::swap(imaginary, otherImaginary_);
    }
}

void FourierPlane::transpose(std::vector<float>& values) {
    for (std::size_t y = 0; y < height_; ++y)
        for (std::size_t x = 0; x < width_; ++x)
            other_[x * height_ + y] = values[y * width_ + x];
    std::swap(values, other_);
}

void FourierPlane::transform() {
    alongColumns();
    transpose(real);
    transpose(imaginary);
    std::swap(width_, height_);
    alongColumns();
}

void FourierPlane::invert() {
    std::swap(real, imaginary); // the conjugate's transform is the inverse's conjugate
    transform();
    std::swap(real, imaginary);
}

} // namespace cmpg
