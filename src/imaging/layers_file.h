// The file of --layers.
#pragma once

#include <cmpg/report.h>

#include <string>

namespace cmpg {

// Layers of one EXR file; those about the guide where there is one.
void writeLayers(const std::string& file, const Layers& layers, bool guided);

} // namespace cmpg
