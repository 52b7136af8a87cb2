// Changes of a scene, or of how it is run, that must not change its image or its derivatives.
#pragma once

#include "outputs.h"
#include "support/generated_geometry.h"

namespace cmpg::test {

// A scene whose outputs, times a weight, are part of the whole.
struct Term {
    Scene scene;
    Sources sources;
    Setup setup = {};
    double weight = 1;
};

enum class Agreement {
    Bits,     // images and forward derivatives bit by bit, gradients but for the order of their sums
    Coupled,  // with equal random numbers but for rounding, which sends a few paths elsewhere
    Expected, // with random numbers of their own
};

struct Relation {
    std::string name;
    Agreement agreement;
    double tolerance; // relative, over what the acceptance rule allows
    bool tame;        // where tails must be light
    bool (*applies)(const Scene& scene);
    std::vector<Term> (*terms)(const Scene& scene, generated::Random& random);
};

const std::vector<Relation>& relations();

} // namespace cmpg::test
