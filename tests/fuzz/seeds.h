// What the seeds of the fuzz targets are written with, and those of scenes and of images.
#pragma once

#include "scene/file_io.h"

#include <filesystem>
#include <string>
#include <vector>

namespace cmpg::fuzz {

// Bytes of numbers, little endian as the machine.
template <class T> std::string bytesOf(const std::vector<T>& values) { return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)}; }
inline std::string textOf(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

struct Folder {
    std::filesystem::path path;
    void write(const std::string& name, const std::string& content) const;
};

std::string pngOf(int width, int height, int channels);

void writeScenes(const Folder& out);
void writeImages(const Folder& out);

} // namespace cmpg::fuzz
