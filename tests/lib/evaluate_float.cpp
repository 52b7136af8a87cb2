// The single-precision half of evaluate.h.
#include "shader_float.h"

#include "evaluate.h"

cmpg::test::Evaluation cmpg::test::evaluateFloat(const Query& query) {
    using Real = float;
    using shader_float::ShaderLibrary;
#include "evaluate.inc"
}
