// What a run of optimize shows: pictures of the views before and after, and the sheet of all.
#pragma once

#include "app/run_folder.h"
#include "imaging/contact_sheet.h"
#include "session/report.h"
#include "session/session.h"

#include <span>

namespace cmpg {

// Samples per pixel of the pictures. Pictures to keep deserve more than those a step throws away; those of many views share the samples of a few.
// After a time budget as many as should fit into a tenth of it, if that is fewer, but 16 at least; of images of more than 128 x 128 pixels
// as much fewer as they are larger, down to 2, since those of large ones would take longer than the steps. `pathSeconds`: what a path takes; 0: not known.
std::uint32_t pictureSamples(const Options& options, std::span<const SeenView> views, double pathSeconds);

// The targets, and pictures at the values where the run began and at the last ones, both by what has been learned: so they differ by what the parameters
// changed, not by how they were sampled. Returns those of the contact sheet: there may be more views than memory holds.
std::vector<ContactSheet::ViewRow> writePictures(v1::Recovery& run, std::uint32_t spp, const std::vector<std::string>& titles, RunFolder& folder);

// `start`: the values of the parameters there.
void writeContactSheet(const Options& options, const Session& session, const v1::Recovery& run, const std::vector<std::vector<float>>& start,
                       std::vector<ContactSheet::ViewRow> views, const RunFolder& folder, Report& report);

} // namespace cmpg
