// Whole files in and out: bounded reads, and writes that never leave half a file behind.
#include "scene/file_io.h"

#include "base/error.h"
#include "base/hash.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <unistd.h>

namespace cmpg {
namespace fs = std::filesystem;

bool fileExists(const fs::path& file) {
    std::error_code ignored;
    return fs::exists(file, ignored);
}

Bytes readFile(const fs::path& file, std::uintmax_t maxBytes) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status))
        throw Error(ErrorKind::Input, "cannot read " + file.string() + ": " + (error ? error.message() : "there is no such file"),
                    "the path is misspelt or relative to another folder", "check the path");
    // Devices and pipes have no size to check before reading.
    if (!fs::is_regular_file(status))
        throw Error(ErrorKind::Input, "cannot read " + file.string() + ": it is not a regular file", "it is a folder, pipe or device",
                    "name a file");
    const std::uintmax_t size = fs::file_size(file, error);
    if (!error && size > maxBytes)
        throw Error(ErrorKind::Input,
                    file.string() + " is too large: " + std::to_string(size) + " bytes, at most " + std::to_string(maxBytes) + " are read",
                    "it is not the file you meant", "split or shrink it");
    std::ifstream stream(file, std::ios::binary);
    Bytes bytes(error ? 0 : size);
    stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    if (error || !stream || std::uintmax_t(stream.gcount()) != size)
        throw Error(ErrorKind::Input, "cannot read " + file.string(), "no permission, or the file changed while it was read",
                    "check its permissions");
    return bytes;
}

void writeFile(const fs::path& file, std::span<const std::uint8_t> bytes) {
    const auto fail = [&](const std::string& reason) -> Error {
        return {ErrorKind::Output, "cannot write " + file.string() + ": " + reason, "no permission, no space, or a folder in the way",
                "choose another output path"};
    };
    std::error_code error;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
    if (error) throw fail(error.message());
    const std::string name = file.filename().string(), part = ".part" + std::to_string(::getpid());
    constexpr std::size_t kLongestName = 255; // in bytes, of most file systems
    const bool fits = name.size() + part.size() <= kLongestName;
    const fs::path aside = file.parent_path() / ((fits ? name : std::to_string(hashOf(std::as_bytes(std::span(name))))) + part);
    {
        errno = 0;
        std::ofstream stream(aside, std::ios::binary | std::ios::trunc);
        stream.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        stream.close();
        if (!stream) {
            const std::string reason = errno ? std::strerror(errno) : "the write failed";
            fs::remove(aside, error);
            throw fail(reason);
        }
    }
    fs::rename(aside, file, error);
    if (error) {
        const std::string reason = error.message();
        fs::remove(aside, error);
        throw fail(reason);
    }
}

} // namespace cmpg
