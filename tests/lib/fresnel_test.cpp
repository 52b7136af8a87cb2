// Fresnel's equations against known truths.
#include "evaluate.h"

#include "shader_double.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;

TEST(Fresnel, NormalIncidenceAndBrewstersAngle) {
    Library library;
    for (const double eta : {0.6, 1.0, 1.33, 1.5, 2.4}) {
        const double r = (eta - 1) / (eta + 1);
        EXPECT_NEAR(library.dielectricBoundary(1, eta).reflected, r * r, 1e-15);
        // There the light that is polarised in the plane of incidence passes, and half of the other part's reflection is left.
        const double c = 1 / std::sqrt(1 + eta * eta), s = (1 - eta * eta) / (1 + eta * eta);
        EXPECT_NEAR(library.dielectricBoundary(c, eta).reflected, 0.5 * s * s, 1e-14);
    }
}

TEST(Fresnel, EnergyAndReciprocity) {
    Library library;
    for (const double eta : {0.5, 0.9, 1.2, 1.5, 3.0})
        for (double c = 0.001; c <= 1; c += 0.013) {
            const auto there = library.dielectricBoundary(c, eta);
            EXPECT_NEAR(there.reflected + there.transmitted, 1, 1e-13);
            if (there.cosine == 0) {
                EXPECT_LE(std::sqrt(1 - c * c), 1.0);
                EXPECT_GE(std::sqrt(1 - c * c), eta * (1 - 1e-12)) << "total reflection only beyond the critical angle";
                continue;
            }
            EXPECT_NEAR(there.cosine * there.cosine, 1 - (1 - c * c) / (eta * eta), 1e-13); // Snell
            EXPECT_NEAR(library.dielectricBoundary(there.cosine, 1 / eta).reflected, there.reflected, 1e-10);
            const double h = 1e-6 * c;
            const double slope = (library.dielectricBoundary(c + h, eta).transmitted - library.dielectricBoundary(c - h, eta).transmitted) / (2 * h);
            EXPECT_NEAR(library.transmittedDerivative(c, eta, there), slope, 1e-5 * (1 + std::abs(slope))) << c << " " << eta;
        }
}

TEST(Fresnel, PaneIsTheSumOfItsReflections) {
    Library library;
    for (double c = 0.02; c <= 1; c += 0.07) {
        const auto one = library.dielectricBoundary(c, 1.5), pane = library.paneBoundary(c, 1.5);
        double reflected = one.reflected, transmitted = 0, within = one.transmitted;
        for (int i = 0; i < 2000; ++i) {
            (i % 2 == 0 ? transmitted : reflected) += within * one.transmitted;
            within *= one.reflected;
        }
        EXPECT_NEAR(pane.reflected, reflected, 1e-9);
        EXPECT_NEAR(pane.transmitted, transmitted, 1e-9);
    }
}

TEST(Fresnel, ConductorsWithoutExtinctionAreDielectrics) {
    Library library;
    for (double c = 0; c <= 1; c += 0.05) {
        const glm::dvec3 r = library.conductorReflected(c, glm::dvec3(1.5, 2, 1.1), glm::dvec3(0));
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(r[i], library.dielectricBoundary(c, glm::dvec3(1.5, 2, 1.1)[i]).reflected, 1e-12);
        const glm::dvec3 mirror = library.conductorReflected(c, glm::dvec3(0), glm::dvec3(1));
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(mirror[i], 1, 1e-12) << "eta 0 reflects all";
        EXPECT_NEAR(library.conductorReflected(c, glm::dvec3(0), glm::dvec3(0)).x, 1, 1e-12) << "without k, too";
    }
    // Normal incidence: ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2).
    const double eta = 0.143119, k = 3.98316;
    EXPECT_NEAR(library.conductorReflected(1, glm::dvec3(eta), glm::dvec3(k)).x, ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k), 1e-12);
}

} // namespace
} // namespace cmpg::test
