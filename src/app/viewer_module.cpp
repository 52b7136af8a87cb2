// The window is a module of its own, loaded when asked for: without it the program needs no window library.
#include "app/viewer_module.h"

#include "app/module_file.h"

#include <dlfcn.h>

namespace cmpg {
namespace {

constexpr const char* kModuleFile = "libcmpg-viewer.so";

constexpr const char* kRemedy = "work without a window: cmpg-vk --headless COMMAND SCENE ...; cmpg-vk --help lists the commands";

} // namespace

ExitStatus runViewerModule(const Options& options) {
    const std::optional<std::filesystem::path> found = findModule(kModuleFile);
    if (!found)
        throw Error(ErrorKind::Device, std::string("there is no window here: ") + kModuleFile + " is missing",
                    "the program was built with -DCMPG_VIEWER=OFF, or the file was not installed; it was looked for in " + modulePlaces(), kRemedy);
    const std::filesystem::path& file = *found;
    void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL); // stays loaded: libraries it brings may have threads
    const auto enter = module ? reinterpret_cast<ViewerMain>(dlsym(module, kViewerMain)) : nullptr;
    if (!enter) {
        const char* const reason = dlerror();
        throw Error(ErrorKind::Device, "the window cannot be loaded: " + std::string(reason ? reason : file.string()),
                    "a library of the window system is missing (package libglfw3), or the file is of another version", kRemedy);
    }
    return ExitStatus(enter(options));
}

} // namespace cmpg
