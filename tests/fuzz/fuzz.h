// What the fuzz targets share: the input as a file, and which ends are right.
#pragma once

#include "base/error.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

// Defined by each target; the fuzzer, or replay.cpp, calls it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace cmpg::fuzz {

using Input = std::span<const std::uint8_t>;

// Ends the process, which the fuzzer reports with the input that led here.
inline void require(bool holds, const char* what) {
    if (holds)
        return;
    std::fprintf(stderr, "does not hold: %s\n", what);
    std::abort();
}

// Of the last input, which a target may look at in several ways: one of them took it; and why one did not. replay.cpp asks, as seeds that are refused reach
// nothing.
inline bool accepted = false;
inline std::string refusal;

// Runs `use`. True: it came to its end. False: it refused the input with one of these codes and a message. Whatever else is thrown ends
// the process.
template <class Use> bool accepts(std::initializer_list<ErrorKind> refusals, Use&& use) {
    try {
        use();
        accepted = true;
        return true;
    } catch (const Error& error) {
        require(std::find(refusals.begin(), refusals.end(), error.kind) != refusals.end(), error.what());
        require(*error.what() != 0, "a refusal says why");
        refusal = error.what();
        return false;
    }
}

// A file in memory that takes each input's bytes in turn.
class MemoryFile {
  public:
    MemoryFile() : descriptor_(::memfd_create("input", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(descriptor_)) {}
    const std::string& holding(Input bytes) const {
        const bool held = ::ftruncate(descriptor_, 0) == 0 && ::pwrite(descriptor_, bytes.data(), bytes.size(), 0) == ssize_t(bytes.size());
        require(held, "the input fits into memory");
        return path_;
    }

  private:
    int descriptor_;
    std::string path_;
};

} // namespace cmpg::fuzz
