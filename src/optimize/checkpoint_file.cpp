// Files of named sections. Little endian: magic, version, number of sections, CRC-32 of these; for each section its name, the bytes of its
// content, CRC-32 of both and the content, content.
#include "optimize/checkpoint_file.h"

#include "base/byte_stream.h"
#include "base/descriptor.h"
#include "base/error.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>
#include <zlib.h>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMagic = 0x0a504b4347504d43; // "CMPGCKP\n"
constexpr std::uint32_t kVersion = 18;
constexpr std::size_t kNameBytes = 8, kHeaderBytes = 8 + 4 + 4 + 4, kSectionBytes = kNameBytes + 8 + 4; // without content

std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before = 0) {
    return bytes.empty() ? before : std::uint32_t(crc32_z(before, bytes.data(), bytes.size())); // which takes null for a wish to begin
}

Error refusal(const std::string& what, const std::string& cause) { return {ErrorKind::Input, what, cause}; }

Error noCheckpoint() { return refusal("it is no checkpoint", "it is another kind of file, damaged at its beginning, or empty"); }

// errno of the first thing that failed; 0: it is on the disk.
int writeSynced(const fs::path& file, std::span<const std::uint8_t> bytes) {
    errno = 0;
    Descriptor out(file, O_WRONLY | O_CREAT | O_TRUNC);
    if (out.get() < 0 || !writeAll(out.get(), bytes) || ::fsync(out.get()) != 0 || !out.close())
        return errno ? errno : EIO;
    return 0;
}

} // namespace

std::vector<fs::path> checkpointFiles(const fs::path& folder) {
    return {folder / "checkpoint.bin", folder / "checkpoint.previous.bin", folder / "checkpoint.part.bin"};
}

Bytes joinSections(const std::vector<FileSection>& sections) {
    ByteWriter out;
    out.put(kMagic);
    out.put(kVersion);
    out.put(std::uint32_t(sections.size()));
    out.put(checksum(out.bytes));
    for (const FileSection& section : sections) {
        std::string name = section.name;
        name.resize(kNameBytes, '\0');
        const std::size_t begin = out.bytes.size();
        out.bytes.insert(out.bytes.end(), name.begin(), name.end());
        out.count(section.bytes.size());
        out.put(checksum(section.bytes, checksum(std::span(out.bytes).subspan(begin))));
        out.bytes.insert(out.bytes.end(), section.bytes.begin(), section.bytes.end());
    }
    return std::move(out.bytes);
}

std::vector<FileSection> parseSections(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < 8 || ByteReader(bytes).get<std::uint64_t>() != kMagic)
        throw noCheckpoint();
    if (bytes.size() < kHeaderBytes)
        throw refusal("it is truncated", "writing or copying it was cut short");
    ByteReader in(bytes.subspan(8));
    const auto version = in.get<std::uint32_t>(), count = in.get<std::uint32_t>();
    if (in.get<std::uint32_t>() != checksum(bytes.first(kHeaderBytes - 4)))
        throw refusal("it is damaged: the checksum of its beginning is wrong", "it was changed after it was written");
    if (version != kVersion)
        throw refusal("it is of version " + std::to_string(version) + ", not " + std::to_string(kVersion), "another version of this program wrote it");
    std::vector<FileSection> sections;
    std::size_t at = kHeaderBytes;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::string number = "section " + std::to_string(i);
        if (bytes.size() - at < kSectionBytes)
            throw refusal("it is truncated before " + number, "writing or copying it was cut short");
        const auto head = bytes.subspan(at, kNameBytes + 8);
        ByteReader sizes(bytes.subspan(at + kNameBytes));
        const auto size = sizes.get<std::uint64_t>();
        const auto sum = sizes.get<std::uint32_t>();
        at += kSectionBytes;
        if (size > bytes.size() - at)
            throw refusal("it is truncated in " + number + ", or damaged there", "writing or copying it was cut short, or it was changed");
        const auto content = bytes.subspan(at, std::size_t(size));
        if (sum != checksum(content, checksum(head)))
            throw refusal("it is damaged: the checksum of " + number + " is wrong", "it was changed after it was written");
        const auto nameEnd = std::find(head.begin(), head.begin() + kNameBytes, 0);
        sections.push_back({std::string(head.begin(), nameEnd), Bytes(content.begin(), content.end())});
        at += content.size();
    }
    if (at != bytes.size())
        throw refusal("it has bytes after its end", "writing or copying it went wrong");
    return sections;
}

std::vector<FileSection> readCheckpointFile(const fs::path& file) try {
    std::ifstream stream(file, std::ios::binary);
    Bytes beginning(kHeaderBytes);
    stream.read(reinterpret_cast<char*>(beginning.data()), std::streamsize(beginning.size()));
    if (stream.gcount() == std::streamsize(kHeaderBytes) && ByteReader(beginning).get<std::uint64_t>() != kMagic)
        throw noCheckpoint();
    return parseSections(readFile(file, std::numeric_limits<std::uintmax_t>::max())); // which says what is wrong with files that cannot be read, too
} catch (const std::bad_alloc&) {
    throw refusal("it does not fit into memory", "it is of a larger machine, or damaged");
} catch (const std::length_error&) {
    throw refusal("it does not fit into memory", "it is of a larger machine, or damaged");
}

void writeCheckpointFile(const fs::path& folder, const std::vector<FileSection>& sections) {
    const std::vector<fs::path> files = checkpointFiles(folder);
    const fs::path &current = files[0], &previous = files[1], &aside = files[2];
    const auto failed = [&](const std::string& reason) {
        return Error(ErrorKind::Output, "cannot write " + current.string() + ": " + reason, "no permission, no space, or a folder that is gone");
    };
    std::error_code error;
    fs::create_directories(folder, error);
    if (const int failure = writeSynced(aside, joinSections(sections)); failure != 0) {
        fs::remove(aside, error); // its room may be what others need
        throw failed(std::strerror(failure));
    }
    if (fs::exists(current, error))
        fs::rename(current, previous, error);
    if (!error)
        fs::rename(aside, current, error);
    if (error)
        throw failed(error.message());
    // The names, too, must outlast a loss of power. File systems that cannot sync a folder refuse with EINVAL.
    errno = 0;
    const Descriptor names(folder, O_RDONLY | O_DIRECTORY);
    if (names.get() < 0 || (::fsync(names.get()) != 0 && errno != EINVAL))
        throw failed(std::strerror(errno));
}

fs::path setCheckpointsAside(const fs::path& folder) {
    const fs::path aside = folder / "checkpoint.replaced.bin";
    bool kept = false;
    for (const fs::path& file : checkpointFiles(folder)) {
        std::error_code error;
        if (!fs::exists(file, error))
            continue;
        if (kept)
            fs::remove(file, error);
        else
            fs::rename(file, aside, error);
        if (error)
            throw Error(ErrorKind::Output, "cannot set " + file.string() + " aside, of an earlier run: " + error.message(), "no permission", "choose another folder");
        kept = true;
    }
    return kept ? aside : fs::path();
}

} // namespace cmpg
