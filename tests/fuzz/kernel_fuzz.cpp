// Files of the cache of kernels: as they are, with their checksum made right, and as the code in a file that is whole.
#include "fuzz.h"
#include "vk/kernel_file.h"

#include <cstring>
#include <zlib.h>

using namespace cmpg;

namespace {

const std::string kKey = "a kernel"; // of the seeds

std::vector<std::uint8_t> repaired(fuzz::Input input) {
    std::vector<std::uint8_t> bytes(input.begin(), input.end());
    if (bytes.size() < 4)
        return bytes;
    const std::size_t end = bytes.size() - 4;
    const auto sum = std::uint32_t(crc32_z(0, bytes.data(), end));
    for (std::size_t i = 0; i < 4; ++i)
        bytes[end + i] = std::uint8_t(sum >> (8 * i));
    return bytes;
}

void use(fuzz::Input input) {
    const auto words = decodeKernel(input, kKey);
    if (!words)
        return;
    fuzz::accepted = true;
    fuzz::require(words->size() >= 5 && words->front() == 0x07230203, "code has a header of SPIR-V");
    for (std::size_t at = 5; at < words->size(); at += (*words)[at] >> 16) {
        const std::size_t length = (*words)[at] >> 16;
        fuzz::require(length > 0 && length <= words->size() - at, "instructions end where the code does");
    }
    fuzz::require(decodeKernel(encodeKernel(kKey, *words), kKey) == words, "code that was read is written and read again as it was");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::Input input(data, size);
    use(input);
    use(repaired(input));
    std::vector<std::uint32_t> words(size / 4);
    if (!words.empty())
        std::memcpy(words.data(), data, 4 * words.size());
    use(encodeKernel(kKey, words));
    return 0;
}
