// What an optimisation is made of, by checksum: scene, starting values, cameras and targets, each under what it is.
#pragma once

#include "optimize/checkpoint.h"
#include "render/renderer.h"

namespace cmpg {

// Of the scene as it is before the first step, and before a renderer was made of it.
Checkpoint::Identity contentIdentity(const Scene& scene, const std::vector<std::uint32_t>& parameters, const std::vector<View>& views,
                                     const std::vector<Target>& targets);

// CRC-32, in hexadecimal digits.
std::string digestOf(const std::vector<std::uint8_t>& bytes);
std::string digestOf(const std::vector<float>& values);
std::string digestOf(const Parameter& parameter); // shape, place on surfaces and values
std::string digestOf(const Target& target);       // values and weights of pixels, whether they are in memory or not

} // namespace cmpg
