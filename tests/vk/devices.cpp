// The devices the tests share.
#include "devices.h"

namespace cmpg::test {
namespace {

Device create(bool portable) { return Device({.select = {}, .validation = false, .portable = portable}); }

} // namespace

Device& device() {
    static Device shared = create(false);
    return shared;
}

Device& portableDevice() {
    static Device shared = create(true);
    return shared;
}

} // namespace cmpg::test
