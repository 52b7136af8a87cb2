// Gives a fuzz target the files of some folders, one after the other: the seeds and what once was found, in the ordinary build. What lies in a folder of
// corpus/ must be accepted: a seed that a format left behind would seed nothing.
//   fuzz_NAME FOLDER...
//   fuzz_NAME --changes N WORDS FOLDER...    N changes of these files instead, the same each time, with words of libFuzzer's dictionary WORDS
#include "fuzz.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

// Of a target that knows its format.
extern "C" [[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);

namespace {

constexpr double kHang = 5; // seconds
std::mt19937 random_(1);
std::vector<Bytes> words_;

std::size_t below(std::size_t bound) { return random_() % bound; }

Bytes contents(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(in), {});
}

// Lines "word", where \xAB is a byte, \" a quote and \\ a backslash.
void readWords(const fs::path& file) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.size() < 2 || line[0] != '"')
            continue;
        Bytes word;
        for (std::size_t i = 1; i + 1 < line.size(); ++i) {
            const bool escaped = line[i] == '\\', byte = escaped && line[i + 1] == 'x';
            word.push_back(std::uint8_t(byte ? std::stoi(line.substr(i + 2, 2), nullptr, 16) : line[i + std::size_t(escaped)]));
            i += byte ? 3 : std::size_t(escaped);
        }
        words_.push_back(word);
    }
}

void give(const Bytes& bytes) {
    const auto begin = std::chrono::steady_clock::now();
    cmpg::fuzz::accepted = false;
    cmpg::fuzz::refusal.clear();
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    cmpg::fuzz::require(seconds < kHang, "an input takes less than 5 s");
}

void changeOnce(Bytes& bytes, std::size_t most) {
    constexpr std::uint8_t kExtremes[] = {0, 1, 0x7f, 0x80, 0xff};
    const std::size_t at = below(bytes.size() + 1), rest = bytes.size() - at;
    const auto place = bytes.begin() + std::ptrdiff_t(at);
    const auto some = [&] { return std::ptrdiff_t(1 + below(std::min<std::size_t>(rest, 64))); };
    switch (rest ? below(6) : 0) {
    case 0: {
        const Bytes& word = words_[below(words_.size())];
        bytes.insert(place, word.begin(), word.end());
        break;
    }
    case 1: *place ^= std::uint8_t(1u << below(8)); break;
    case 2: std::fill_n(place, some(), kExtremes[below(std::size(kExtremes))]); break;
    case 3: bytes.erase(place, place + some()); break;
    case 4: { // a piece from elsewhere
        const Bytes piece(place, place + some());
        bytes.insert(bytes.begin() + std::ptrdiff_t(below(bytes.size() + 1)), piece.begin(), piece.end());
        break;
    }
    case 5: bytes.resize(at); break;
    }
    bytes.resize(std::min(bytes.size(), most));
}

} // namespace

// The fuzzer's, which a target's own changes build on.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) {
    Bytes bytes(data, data + size);
    for (std::size_t i = 0, count = 1 + below(3); i < count; ++i)
        changeOnce(bytes, most);
    std::copy(bytes.begin(), bytes.end(), data);
    return bytes.size();
}

int main(int argc, char** argv) {
    std::vector<std::string> arguments(argv + 1, argv + argc);
    int changes = 0;
    if (arguments.size() > 2 && arguments[0] == "--changes") {
        changes = std::stoi(arguments[1]);
        readWords(arguments[2]);
        arguments.erase(arguments.begin(), arguments.begin() + 3);
        cmpg::fuzz::require(!words_.empty(), "there are words");
    }
    std::vector<fs::path> files;
    for (const fs::path folder : arguments)
        if (fs::exists(folder)) // not every target was ever brought down
            for (const auto& entry : fs::directory_iterator(folder))
                files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    cmpg::fuzz::require(!files.empty(), "there are files");
    // The last line names what ended the process.
    for (std::size_t i = 0; changes == 0 && i < files.size(); ++i) {
        std::printf("%s\n", files[i].c_str());
        std::fflush(stdout);
        give(contents(files[i]));
        const bool seed = files[i].parent_path().parent_path().filename() == "corpus";
        cmpg::fuzz::require(cmpg::fuzz::accepted || !seed, ("a seed is accepted, which make_seeds may have to write anew: " + cmpg::fuzz::refusal).c_str());
    }
    for (int change = 0; change < changes; ++change) {
        const fs::path& file = files[std::size_t(change) % files.size()];
        std::printf("%s, change %d\n", file.c_str(), change);
        std::fflush(stdout);
        Bytes bytes = contents(file);
        const std::size_t size = bytes.size(), most = 2 * size + 64;
        bytes.resize(most);
        bytes.resize(LLVMFuzzerCustomMutator ? LLVMFuzzerCustomMutator(bytes.data(), size, most, random_()) : LLVMFuzzerMutate(bytes.data(), size, most));
        give(bytes);
    }
    std::printf("%zu inputs\n", changes ? std::size_t(changes) : files.size());
}
