// Targets of more views than memory should hold: read when a step needs them.
#include "optimize/loaded_target.h"

#include "base/error.h"
#include "optimize/content_identity.h"

namespace cmpg {
namespace {

bool isStreamed(const Target& target) { return target.image.values.empty() && target.read; }

Target readAgain(const Target& target) {
    Target result = target.read();
    if (digestOf(result) != target.digest)
        throw Error(ErrorKind::Input, "target " + target.name + " is another one than at the start", "its file was changed while the program needed it",
                    "begin again, and leave the files of targets alone meanwhile");
    return result;
}

} // namespace

Target streamed(std::function<Target()> read) {
    Target target = read();
    target.digest = digestOf(target);
    target.image.values = std::vector<float>();
    target.mask = std::vector<float>();
    target.clipped = std::vector<std::uint8_t>();
    target.read = std::move(read);
    return target;
}

LoadedTarget::LoadedTarget(const Target& target) : own_(isStreamed(target) ? readAgain(target) : Target()), target_(isStreamed(target) ? own_ : target) {}

} // namespace cmpg
