// Names and files of exported scenes.
#include "scene/export_folder.h"

#include "base/error.h"
#include "base/hash.h"
#include "scene/file_io.h"
#include "scene/parameter_values.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

// Bytes of the character beyond ASCII at a place of the text; 0 where there is none, or it is no valid UTF-8.
std::size_t characterBytes(const std::string& text, std::size_t at, char32_t& code) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? char32_t(static_cast<unsigned char>(text[i])) : 0; };
    const char32_t first = byte(at);
    const std::size_t bytes = first >= 0xc0 && first < 0xe0 ? 2 : first >= 0xe0 && first < 0xf0 ? 3 : first >= 0xf0 && first < 0xf8 ? 4 : 0;
    if (bytes == 0)
        return 0;
    code = first & (0x7fu >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(at + i) & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (byte(at + i) & 0x3f);
    }
    constexpr char32_t kFirst[] = {0, 0, 0x80, 0x800, 0x10000}; // by bytes: what is written in no fewer
    return code < kFirst[bytes] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000) ? 0 : bytes;
}

// Characters beyond ASCII that are seen in a name: no controls, spaces, marks of direction, nor what is no character.
bool isSeen(char32_t c) {
    const auto within = [c](char32_t first, char32_t last) { return c >= first && c <= last; };
    return c > 0xa0 && c != 0xad && !within(0x2000, 0x200f) && !within(0x2028, 0x202f) && !within(0x205f, 0x206f) && c != 0x3000 && c != 0xfeff &&
           !within(0xfff0, 0xffff) && c < 0xe0000;
}

// What is unsafe percent-encoded, as far as the whole takes no more than `most` bytes; whole characters and codes.
std::string safe(const std::string& text, std::size_t most = std::string::npos) {
    std::string out;
    for (std::size_t at = 0, bytes = 0; at < text.size(); at += bytes) {
        char32_t code = 0;
        bytes = characterBytes(text, at, code);
        const bool kept = bytes > 0 && isSeen(code);
        bytes = std::max<std::size_t>(bytes, 1);
        const std::string piece = text.substr(at, bytes), next = kept ? piece : percentEncode(piece, at == 0 ? " -_#()" : " .-_#()"); // no hidden files
        if (out.size() + next.size() > most)
            break;
        out += next;
    }
    return out;
}

} // namespace

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

std::string fileName(const std::string& parameterName) {
    constexpr std::size_t kMost = 120, kMostOfSlot = 40; // bytes: a name on disk has at most 255, with what others append
    std::string name = safe(parameterName);
    if (name.size() <= kMost)
        return name;
    char hash[32];
    std::snprintf(hash, sizeof hash, "~%016llx", static_cast<unsigned long long>(hashOf(std::as_bytes(std::span(parameterName)))));
    const std::size_t dot = parameterName.rfind('.');
    std::string slot; // with its dot
    if (dot != std::string::npos)
        slot.append(1, '.').append(safe(parameterName.substr(dot + 1)));
    if (slot.size() > kMostOfSlot)
        slot.clear();
    return safe(parameterName, kMost - std::strlen(hash) - slot.size()) + hash + slot;
}

Image imageOf(const Parameter& parameter) {
    Image image(int(parameter.width), int(parameter.height), int(parameter.channels));
    image.values = valuesOf(parameter);
    return image;
}

fs::path ExportFolder::sourceAt(const std::string& name) const {
    std::error_code error;
    const fs::path file = fs::weakly_canonical(folder_ / name, error);
    return !error && sources_.contains(file) ? file : fs::path();
}

void ExportFolder::reserve(const std::string& name) {
    if (!sourceAt(name).empty())
        throw Error(ErrorKind::Output, "cannot export to " + folder_.string() + ": it would overwrite " + name + ", which the scene is read from",
                    "the output folder is the scene's own", "choose another folder");
    taken_.emplace(name, fs::path());
}

std::string ExportFolder::add(const std::string& stem, const std::string& extension, std::span<const std::uint8_t> bytes) {
    std::string name = stem + extension;
    for (int n = 2; !sourceAt(name).empty() || !taken_.emplace(name, fs::path()).second; ++n)
        name = stem + "-" + std::to_string(n) + extension;
    writeFile(folder_ / name, bytes);
    return name;
}

std::string ExportFolder::copy(const fs::path& source, const fs::path& relative) {
    std::string name = relative.generic_string();
    for (int n = 2;; ++n) {
        if (const fs::path there = sourceAt(name); there.empty() || there == source) {
            const auto [taken, isNew] = taken_.emplace(name, source);
            if (!isNew && taken->second == source)
                return name;
            if (isNew)
                break;
        }
        name = (relative.parent_path() / (relative.stem().string() + "-" + std::to_string(n) + relative.extension().string())).generic_string();
    }
    const fs::path target = folder_ / name;
    std::error_code error;
    if (!fs::equivalent(source, target, error))
        writeFile(target, readFile(source));
    return name;
}

} // namespace cmpg
