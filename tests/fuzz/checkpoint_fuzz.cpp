// Checkpoints: as they are, and with their version and checksums made right, so that what stands behind these is reached.
#include "base/byte_stream.h"
#include "fuzz.h"
#include "optimize/checkpoint.h"
#include "optimize/learned.h"
#include "optimize/linear_model.h"

#include <zlib.h>

using namespace cmpg;

namespace {

constexpr std::size_t kMagicBytes = 8, kHeaderBytes = kMagicBytes + 4 + 4, kNameBytes = 8, kSumBytes = 4; // of the header without its sum; of a section

void overwrite(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i)
        bytes[at + i] = std::uint8_t(value >> (8 * i));
}

std::vector<std::uint8_t> repaired(fuzz::Input input) {
    std::vector<std::uint8_t> bytes(input.begin(), input.end());
    const auto sum = [&](std::size_t begin, std::size_t size, unsigned long before) { return size ? crc32_z(before, &bytes[begin], size) : before; };
    if (bytes.size() < kHeaderBytes + kSumBytes)
        return bytes;
    static const Bytes current = joinSections({});
    overwrite(bytes, kMagicBytes, ByteReader(std::span(current).subspan(kMagicBytes)).get<std::uint32_t>());
    overwrite(bytes, kHeaderBytes, std::uint32_t(sum(0, kHeaderBytes, 0)));
    for (std::size_t at = kHeaderBytes + kSumBytes; bytes.size() - at >= kNameBytes + 8 + kSumBytes;) {
        const std::size_t content = at + kNameBytes + 8 + kSumBytes;
        const auto size = ByteReader(std::span(bytes).subspan(at + kNameBytes)).get<std::uint64_t>();
        if (size > bytes.size() - content)
            break;
        overwrite(bytes, content - kSumBytes, std::uint32_t(sum(content, std::size_t(size), sum(at, kNameBytes + 8, 0))));
        at = content + std::size_t(size);
    }
    return bytes;
}

// A small optimisation, by the optimiser that its configuration names, goes on from it for a step.
void goOn(const Checkpoint& checkpoint) {
    OptimizeConfig config;
    config.steps = 20;
    for (const EnumName<OptimizerKind>& optimizer : kOptimizers)
        if (checkpoint.config.find('"' + std::string(optimizer.name) + '"') != std::string::npos)
            config.optimizer.kind = optimizer.value;
    config.targets = test::makeTargets(1, 2, 2);
    Scene scene = test::makeScene();
    test::LinearModel model(scene, 1, 2, 2, 0.1);
    Optimization run(model, scene, config, {0, 1});
    resume(checkpoint, run, model);
    const std::vector<FileSection> written = checkpointSections(run, model, checkpoint.identity, checkpoint.config, checkpoint.madeWith);
    fuzz::require(readCheckpoint(written).state.step == checkpoint.state.step, "what was resumed is written and read again");
    if (run.state().step < config.steps)
        run.step();
}

void use(fuzz::Input bytes) {
    fuzz::accepts({ErrorKind::Input, ErrorKind::Numerical}, [&] {
        const Checkpoint checkpoint = readCheckpoint(parseSections(bytes));
        try {
            ByteReader in(checkpoint.learned);
            getLearned(in);
        } catch (const Malformed&) {
        }
        goOn(checkpoint);
    });
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    use({data, size});
    use(repaired({data, size}));
    return 0;
}
