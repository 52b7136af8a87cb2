// Guides on disk: versioned, checked, bound to the scene's geometry and to the names of the parameters.
#pragma once

#include "base/byte_stream.h"
#include "guiding/field/sd_tree.h"
#include "guiding/policy/sampling_choice.h"

#include <filesystem>
#include <map>

namespace cmpg {

// What a guide needs to be used again.
struct GuideContext {
    std::uint64_t geometry = 0;              // hash of the scene's triangles
    std::vector<std::string> parameters;     // names, in the order they were asked for
    std::map<Sampling, SamplingFigures> figures; // of derivative passes without roulette
    std::map<Sampling, SamplingFigures> rouletteFigures;
    std::map<Sampling, SamplingFigures> imageFigures; // of images
    double reference = 0; // expected derivative contribution of a path, per unit of mean |adjoint|: what roulette compares with
};

// Error(Output) if it cannot be written; written aside and renamed.
void saveGuide(const std::filesystem::path& file, const SdTree& tree, const GuideContext& context);

struct LoadedGuide {
    SdTree tree;
    GuideContext context;
};
// Error(Input) on a file that is none, of another version, truncated, or whose contents do not validate; the message says which.
LoadedGuide loadGuide(const std::filesystem::path& file);

// The parts that other files have in common with a guide's. What is read is checked as a guide is; Malformed says what is wrong.
void putTree(ByteWriter& out, const SdTree& tree);
SdTree getTree(ByteReader& in);
void putFigures(ByteWriter& out, const SamplingFigures& figures);
SamplingFigures getFigures(ByteReader& in);

} // namespace cmpg
