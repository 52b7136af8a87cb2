// Places to write to: checked before expensive work starts, written aside and renamed.
#include "session/output.h"

#include "base/communicator.h"
#include "base/error.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <unistd.h>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void refuse(const fs::path& path, const std::string& cause, const std::string& remedy) {
    throw Error(ErrorKind::Output, "cannot write '" + path.string() + "'", cause, remedy);
}

// A name in `folder` that other processes do not use.
fs::path asideName(const fs::path& folder, const std::string& name) {
    return folder / ("." + name + "." + std::to_string(getpid()) + ".tmp");
}

void probe(const fs::path& folder, const fs::path& wanted) {
    const fs::path file = asideName(folder, "cmpg-vk-probe");
    errno = 0;
    const bool made = bool(std::ofstream(file));
    const int error = errno;
    std::error_code ignored;
    fs::remove(file, ignored);
    if (!made)
        refuse(wanted, error ? std::strerror(error) : "the folder cannot be written", "choose another place");
}

std::string lowerCase(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

} // namespace

fs::path folderOf(const fs::path& file) {
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

void requireWritableFile(const fs::path& file, const char* extension) {
    if (!ranks().isRoot()) // writes nothing
        return;
    std::error_code error;
    if (fs::is_directory(file, error))
        refuse(file, "it is a folder", "name a file in it");
    if (extension && lowerCase(file.extension().string()) != extension)
        throw Error(ErrorKind::Usage, "'" + file.string() + "' does not end in " + std::string(extension), "that is the format of the result",
                    "end its name in " + std::string(extension) + (std::strcmp(extension, ".exr") == 0 ? "; 'view' makes a .png of it" : ""));
    const fs::path folder = folderOf(file);
    if (!fs::is_directory(folder, error))
        refuse(file, "there is no folder '" + folder.string() + "'", "make it first");
    probe(folder, file);
}

void requireWritableFolder(const fs::path& folder) {
    if (!ranks().isRoot())
        return;
    std::error_code error;
    if (!fs::is_directory(folder, error)) {
        if (fs::exists(folder, error))
            refuse(folder, "it is a file, and a folder is needed", "choose another name with -o");
        fs::create_directory(folder, error);
        if (error)
            refuse(folder, error.message(), "make the folder it is to stand in first");
    }
    probe(folder, folder);
}

void requireWritableGuide(const fs::path& file) {
    if (file.empty() || !ranks().isRoot())
        return;
    makeFolder(folderOf(file));
    requireWritableFile(file, nullptr);
}

void makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored))
        throw Error(ErrorKind::Output, "cannot make the folder " + folder.string(), error ? error.message() : "a file of that name is in the way",
                    "choose another place");
}

void writeTextFile(const fs::path& file, const std::string& text) {
    const fs::path aside = asideName(folderOf(file), file.filename().string());
    std::ofstream out(aside, std::ios::binary);
    out << text;
    out.close();
    std::error_code error;
    if (out)
        fs::rename(aside, file, error);
    if (out && !error)
        return;
    std::error_code ignored;
    fs::remove(aside, ignored);
    refuse(file, error ? error.message() : "the disk may be full", "choose another place with -o");
}

} // namespace cmpg
