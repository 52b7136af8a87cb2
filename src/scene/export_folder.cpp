// Names and files of exported scenes.
#include "scene/export_folder.h"

#include "scene/file_io.h"
#include "scene/parameter_values.h"

namespace cmpg {
namespace fs = std::filesystem;

std::string percentEncode(const std::string& text, const std::string& kept) {
    static const char* const kDigits = "0123456789ABCDEF";
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || kept.find(c) != std::string::npos;
        if (plain)
            out += c;
        else
            (out += '%') += {kDigits[byte >> 4], kDigits[byte & 15]};
    }
    return out;
}

std::string fileName(const std::string& parameterName) { return percentEncode(parameterName, " .-_#()"); }

Image imageOf(const Parameter& parameter) {
    Image image(int(parameter.width), int(parameter.height), int(parameter.channels));
    image.values = valuesOf(parameter);
    return image;
}

std::string ExportFolder::add(const std::string& stem, const std::string& extension, std::span<const std::uint8_t> bytes) {
    std::string name = stem + extension;
    for (int n = 2; !taken_.insert(name).second; ++n)
        name = stem + "-" + std::to_string(n) + extension;
    writeFile(folder_ / name, bytes);
    return name;
}

void ExportFolder::copy(const fs::path& source, const fs::path& relative) {
    taken_.insert(relative.generic_string());
    const fs::path target = folder_ / relative;
    std::error_code error;
    if (!fs::equivalent(source, target, error))
        writeFile(target, readFile(source));
}

} // namespace cmpg
