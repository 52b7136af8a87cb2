// Writes the seeds of the fuzz targets: small files that together have every feature their readers know. Those of meshes and of Mitsuba's scenes are text, and
// written by hand.
//   make_seeds tests/fuzz/corpus
#include "guiding/guide_file.h"
#include "optimize/checkpoint.h"
#include "optimize/learned.h"
#include "optimize/linear_model.h"
#include "seeds.h"
#include "support/scene_mutation.h"
#include "vk/kernel_file.h"

#include <cstdio>

using namespace cmpg;
using namespace cmpg::fuzz;
namespace fs = std::filesystem;

void Folder::write(const std::string& name, const std::string& content) const {
    writeFile(path / name, {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
}

namespace {

// ---- guides and checkpoints

SdTree learnedTree() {
    SdTreeConfig config;
    config.cellRecords = 10;
    config.maxNodes = 40;
    SdTree tree(glm::vec3(-1), glm::vec3(1, 2, 3), config);
    std::vector<CellRecords> records;
    for (std::uint32_t cell = 0; cell < tree.cells().size(); ++cell) {
        CellRecords r{cell, 20 + cell, 3, 1, {}};
        for (const QuadNode& node : tree.cells()[cell].nodes)
            r.leaves.push_back({{{1, 0.5, 0}, {double(cell), 0, 0}, {0, 0, 2}, {node.child[0] ? 0.0 : 7.0, 1, 1}}});
        records.push_back(std::move(r));
    }
    tree.update(records);
    return tree;
}

void writeGuides(const Folder& out) {
    GuideContext context;
    context.geometry = 0x1234;
    context.parameters = {"wall.baseColor", "lamp.emission"};
    context.figures[Sampling::Bsdf] = {0.5, 3, 2};
    context.figures[Sampling::Conditional] = {0.25, 4, 2};
    context.rouletteFigures[Sampling::Conditional] = {0.2, 5, 1};
    context.imageFigures[Sampling::Primal] = {0.1, 3, 4};
    context.reference = 0.75;
    saveGuide(out.path / "learned.guide", learnedTree(), context);
    SdTreeConfig small;
    small.maxNodes = 1;
    saveGuide(out.path / "empty.guide", SdTree(glm::vec3(0), glm::vec3(1), small), {});
}

void writeCheckpoints(const Folder& out) {
    for (const EnumName<OptimizerKind>& optimizer : kOptimizers) {
        OptimizeConfig config;
        config.steps = 20;
        config.optimizer.kind = optimizer.value;
        config.targets = test::makeTargets(1, 2, 2);
        Scene scene = test::makeScene();
        test::LinearModel model(scene, 1, 2, 2, 0.1);
        Optimization run(model, scene, config, {0, 1});
        run.step();
        run.step();
        const std::string name = optimizer.name, text = R"({"command": "optimize", "steps": 20, "optimizer": ")" + name + "\"}";
        std::vector<FileSection> sections = checkpointSections(run, model, {{"--loss", "\"mse\""}, {"scene", "0"}}, text, "a device");
        if (optimizer.value == OptimizerKind::Auto) {
            ByteWriter learned;
            const GuidedState state{.images = {{{0.5, 3, 2}, {0.25, 4, 1}}, {0.5, 0}, 1, 3, 2}, .derivatives = {{{0.5, 3, 2}}, {0.9}, 0, 1, 0},
                                    .exploration = {.noise = 0.5, .watched = 2, .urgent = true, .spent = 100, .trials = 50}, .reference = 0.5, .trained = true, .step = 2};
            const SdTree tree = learnedTree();
            putLearned(learned, state, &tree);
            sections.back().bytes = std::move(learned.bytes);
        }
        out.write(name + ".bin", textOf(joinSections(sections)));
    }
}

// ---- kernels

void writeKernels(const Folder& out) {
    // A header, a capability, a memory model; the same with many names, which compress well.
    std::vector<std::uint32_t> words = {0x07230203, 0x00010500, 0, 1, 0, 2u << 16 | 17, 1, 3u << 16 | 14, 0, 1};
    const auto write = [&](const char* name) { out.write(name, textOf(encodeKernel("a kernel", words))); };
    write("small.spirv");
    out.write("code.words", bytesOf(words));
    for (int i = 0; i < 500; ++i)
        words.insert(words.end(), {3u << 16 | 5, 1, 0x61});
    write("names.spirv");
}

// ---- command lines

void writeOptions(const Folder& out) {
    out.write("render.txt", "--headless\nrender\nroom.gltf\n-o\nimage.exr\n--spp\n256\n--sampling\nprimal\n--train\n4\n--set\na.baseColor=0.5,0.5,0.5\n");
    out.write("gradient.txt", "gradient\nroom.gltf\n--param\npainting.*\n--target\nref.exr\n-o\ng.exr\n--error-target\n1%\n--loss=smape\n--positivize\n");
    out.write("optimize.txt", "optimize\nroom.gltf\n--param\na.baseColor\n--target\ncam=ref.exr\n-o\nrun\n--rate\nbaseColor=0.1\n--schedule\ncosine\n"
                              "--checkpoint-every\n10m\n--time-budget\n5min\n");
    out.write("compare.txt", "compare\nroom.gltf\n--param\na.baseColor\n--methods\nplain,conditional+roulette,ours+nonee\n--time\n20\n-o\nout\n--mode\nreverse,forward\n");
    out.write("tradeoff.txt", "tradeoff\nroom.gltf\n--param\na.baseColor\n-o\nout\n--seeds\n4\n--quality\npreview\n");
    out.write("view.txt", "view\nimage.exr\n-o\na.png\n--signed\n--exposure\n-1.5\n--layer\nnormal\n");
    out.write("guide.txt", "guide\na.guide\n--weights\n1,2\n--cell\n3\n--csv\n");
    out.write("help.txt", "render\n--help\n");
    out.write("open.txt", "room.gltf\n--display-server\n[::1]:14158\n--device\nllvm\n");
    out.write("config.txt", "--config\nrun.json\n--spp\n9\n-o\nrun\n\n"
                            R"({"command":"optimize","input":"room.gltf","param":["a.baseColor"],"target":["ref.exr"],"steps":10,"rate":["0.1"],"error-target":0.01,)"
                            R"("sampler":"sobol","roulette":"adjoint","seed":7,"guide-share":0.5,"set":["a=1"],"made-with":{"device":"x"}})");
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "make_seeds FOLDER\n");
        return 2;
    }
    const fs::path root = argv[1];
    writeScenes({root / "scene"});
    writeImages({root / "image"});
    writeGuides({root / "guide"});
    writeCheckpoints({root / "checkpoint"});
    writeKernels({root / "kernel"});
    writeOptions({root / "options"});
}
