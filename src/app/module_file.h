// Modules that the program loads when they are asked for, so that it needs none of their libraries.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace cmpg {

// Beside the program as in a build folder, or where it is installed; none: in neither.
std::optional<std::filesystem::path> findModule(const std::string& file);
// Where it looks, for an error.
std::string modulePlaces();

} // namespace cmpg
