// Gives a fuzz target the files of some folders, one after the other: the seeds and what once was found, in the ordinary build.
#include "fuzz.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace fs = std::filesystem;

// The fuzzer's, which a target's own mutations build on; nothing is mutated here.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t*, std::size_t size, std::size_t) { return size; }

int main(int argc, char** argv) {
    constexpr double kHang = 5; // seconds
    std::vector<fs::path> files;
    for (int i = 1; i < argc; ++i)
        if (fs::exists(argv[i])) // not every target was ever brought down
            for (const auto& entry : fs::directory_iterator(argv[i]))
                files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
        std::printf("%s\n", file.c_str());
        std::fflush(stdout); // the last line names what ended the process
        std::ifstream in(file, std::ios::binary);
        const std::vector<char> bytes(std::istreambuf_iterator<char>(in), {});
        const auto begin = std::chrono::steady_clock::now();
        LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        cmpg::fuzz::require(seconds < kHang, "an input takes less than 5 s");
    }
    std::printf("%zu inputs\n", files.size());
    return files.empty() ? 1 : 0;
}
