// The files of an exported scene.
#pragma once

#include "scene/image.h"
#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>

namespace cmpg {

// Names its files so that they clash neither with each other nor with what was copied, and overwrite nothing that the scene is read from.
class ExportFolder {
  public:
    // `sources`: the files of the scene, as Scene::files has them.
    ExportFolder(std::filesystem::path folder, const std::vector<std::filesystem::path>& sources)
        : folder_(std::move(folder)), sources_(sources.begin(), sources.end()) {}

    // Keeps a name for a file that has no other. Throws Error(Output) where that is a file of the scene.
    void reserve(const std::string& name);
    // Writes a file and returns its name, relative to the folder.
    std::string add(const std::string& stem, const std::string& extension, std::span<const std::uint8_t> bytes);
    // Copies a file to this place in the folder, or beside it where another file has the name. Returns where, relative to the folder, with slashes.
    std::string copy(const std::filesystem::path& source, const std::filesystem::path& relative);
    const std::filesystem::path& path() const { return folder_; }

  private:
    // Of the scene, if it is one, the file that stands there; else nothing.
    std::filesystem::path sourceAt(const std::string& name) const;

    std::filesystem::path folder_;
    std::set<std::filesystem::path> sources_;
    std::map<std::string, std::filesystem::path> taken_; // names, and what was copied there; empty: written
};

// Percent-encodes everything but letters, digits and the characters of `kept`.
std::string percentEncode(const std::string& text, const std::string& kept);

// A parameter's name as a file name: everything but letters and digits of any script, space, and .-_#() percent-encoded, a dot at the beginning too. One of
// more than 120 bytes is cut: ~ and a hash of the whole name follow, which no other name has, then the slot.
std::string fileName(const std::string& parameterName);

// Current values as a picture.
Image imageOf(const Parameter& parameter);

} // namespace cmpg
