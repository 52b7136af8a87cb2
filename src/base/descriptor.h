// File descriptors that close themselves, and whole reads and writes with them.
#pragma once

#include <cerrno>
#include <cstdint>
#include <fcntl.h>
#include <filesystem>
#include <span>
#include <unistd.h>
#include <utility>

namespace cmpg {

class Descriptor {
  public:
    Descriptor(const std::filesystem::path& path, int flags) : Descriptor(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
    explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
    ~Descriptor() {
        if (descriptor_ >= 0)
            ::close(descriptor_);
    }
    Descriptor(const Descriptor&) = delete;
    int get() const { return descriptor_; } // negative: it could not be opened
    bool close() { return ::close(std::exchange(descriptor_, -1)) == 0; } // which may tell of writes that failed

  private:
    int descriptor_;
};

inline bool writeAll(int descriptor, std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        bytes = bytes.subspan(std::size_t(written));
    }
    return true;
}

inline bool readAll(int descriptor, std::span<std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t found = ::read(descriptor, bytes.data(), bytes.size());
        if (found < 0 && errno == EINTR)
            continue;
        if (found <= 0)
            return false;
        bytes = bytes.subspan(std::size_t(found));
    }
    return true;
}

} // namespace cmpg
