// Places to write to: checked before expensive work starts, written aside and renamed.
#pragma once

#include <filesystem>
#include <string>

namespace cmpg {

// The folder a file will be written in.
std::filesystem::path folderOf(const std::filesystem::path& file);
// They throw Error(Output) where nothing can be written: they try it with a file that they remove again.
void requireWritableFile(const std::filesystem::path& file, const char* extension); // null: any
void requireWritableFolder(const std::filesystem::path& folder); // makes the folder itself if its parent exists
void requireWritableGuide(const std::filesystem::path& file);    // of --save-guide, empty for none; makes its folder

// With those that it stands in; Error(Output) where that fails.
void makeFolder(const std::filesystem::path& folder);

void writeTextFile(const std::filesystem::path& file, const std::string& text);

} // namespace cmpg
