// Files of named sections that survive: each is checked by a sum of its own, written aside, synced and renamed, and the one before is kept.
#pragma once

#include "scene/file_io.h"

#include <string>

namespace cmpg {

struct FileSection {
    std::string name; // 1 to 8 characters
    Bytes bytes;
};

// Of a folder, in the order they are tried: the newest that was named, the one before it, and one that was complete but not named yet.
std::vector<std::filesystem::path> checkpointFiles(const std::filesystem::path& folder);

// Replaces the first of them, which becomes the second. Makes the folder where it is gone. Error(Output) if anything of it fails: then
// what was there is still there.
void writeCheckpointFile(const std::filesystem::path& folder, const std::vector<FileSection>& sections);

// Renames the newest of them to checkpoint.replaced.bin, in place of an older one of that name, and removes the others: what begins in this folder is another
// run. Returns the new name, empty where there was none. Error(Output) if that fails.
std::filesystem::path setCheckpointsAside(const std::filesystem::path& folder);

// Of any size, since one of a texture of 8192 x 8192 texels has 6 GB. Error(Input) on what is no checkpoint, which is not read into memory, and on what does not
// fit there; as parseSections().
std::vector<FileSection> readCheckpointFile(const std::filesystem::path& file);
// Error(Input) on anything that was not written like this, to the last bit; the message says what is wrong.
std::vector<FileSection> parseSections(std::span<const std::uint8_t> bytes);
Bytes joinSections(const std::vector<FileSection>& sections);

} // namespace cmpg
