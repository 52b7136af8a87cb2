// Runs kernels of tests/shaders that take one query an invocation.
#pragma once

#include "lib/evaluate.h"
#include "vk/device.h"

#include <vector>

namespace cmpg::test {

template <class Result, class Query> std::vector<Result> evaluateOn(Device& device, const char* name, const std::vector<Query>& queries) {
    Buffer input(device, "queries", queries.size() * sizeof(Query), MemoryKind::Transient);
    Buffer output(device, "results", queries.size() * sizeof(Result), MemoryKind::Transient);
    input.uploadAll(queries);
    const Kernel kernel(device, name);
    Bindings bindings;
    bindings.set(0, input).set(1, output);
    Commands commands(device);
    commands.dispatch(kernel, bindings, queries.size(), std::uint32_t(queries.size()));
    commands.submitAndWait();
    return output.downloadAll<Result>(queries.size());
}

struct BsdfResult { // as in evaluate_bsdf.comp
    glm::vec3 value, valueWithDerivatives;
    float pdf;
    glm::vec3 baseColor, roughness, metallic, specular, normalX, normalY, normalZ;

    glm::dmat3 normal() const { return glm::transpose(glm::dmat3(glm::dvec3(normalX), glm::dvec3(normalY), glm::dvec3(normalZ))); }
};

} // namespace cmpg::test
