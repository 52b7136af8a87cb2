// What stands between a glTF file and tinygltf: the file's JSON is checked, then rewritten into what tinygltf 2.7 reads right.
#pragma once

#include "scene/gltf/json_view.h"

namespace cmpg {

// Types, ranges, sizes and indices of everything that is read later; fails at the first place that is wrong. tinygltf itself
// ignores values of the wrong type, cuts integers to 32 bits, and looks up images in buffers without checking their bounds.
void checkGltf(const JsonView& root);

// Buffers are named by this and their number in the rewritten file.
constexpr const char* kBufferToken = "buffer";

// The same scene with tokens for file names and without what tinygltf refuses, cuts short, or insists on though nobody needs it.
Json rewrittenForTinyGltf(Json root);

} // namespace cmpg
