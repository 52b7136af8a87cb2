// Modules that the program loads when they are asked for.
#include "app/module_file.h"

namespace cmpg {
namespace fs = std::filesystem;
namespace {

fs::path programFolder() {
    std::error_code error;
    return fs::read_symlink("/proc/self/exe", error).parent_path();
}

} // namespace

std::optional<fs::path> findModule(const std::string& file) {
    std::error_code error;
    for (const fs::path& folder : {programFolder(), programFolder() / CMPG_MODULE_FOLDER})
        if (fs::exists(folder / file, error))
            return folder / file;
    return std::nullopt;
}

std::string modulePlaces() { return programFolder().string() + " and " + (programFolder() / CMPG_MODULE_FOLDER).lexically_normal().string(); }

} // namespace cmpg
