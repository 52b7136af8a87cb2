// Guide files: what was saved comes back, and nothing else gets in.
#include "guiding/guide_file.h"
#include "guiding/samples.h"

#include "base/error.h"
#include "scene/file_io.h"
#include "support/temp_folder.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

class GuideFileTest : public testing::Test {
  protected:
    fs::path file() const { return folder_ / "some.guide"; }

    // A grown tree of few bytes, and a context with something everywhere.
    static SdTree smallTree(std::uint32_t cellRecords = 500) {
        SdTreeConfig config;
        config.cellRecords = cellRecords;
        config.directionShare = 0.1;
        config.maxNodes = 5000;
        SdTree tree({-1, -2, 0.1f}, {1, 2, 3}, config);
        for (std::uint32_t i = 0; i < 2; ++i)
            tree.update(place(tree, randomSamples(tree.lower(), tree.upper(), 2000, i)));
        return tree;
    }
    static GuideContext someContext() {
        GuideContext context;
        context.geometry = 0x0123456789abcdef;
        context.parameters = {"painting.baseColor", "", "wall\n\"\xc3\xa4\".roughness"};
        context.figures[Sampling::Bsdf] = {1.0 / 3, 7.25, 8};
        context.figures[Sampling::Conditional] = {0.1, 9, 8};
        context.rouletteFigures[Sampling::Primal] = {std::numeric_limits<double>::denorm_min(), 1e300, ~0u};
        context.reference = 0.7;
        return context;
    }

    // The message of the refusal; empty if the file is taken.
    std::string refusal(const Bytes& bytes) const {
        writeFile(file(), bytes);
        try {
            loadGuide(file());
        } catch (const Error& error) {
            EXPECT_EQ(error.kind, ErrorKind::Input);
            return error.what();
        }
        return {};
    }
    static bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

    // Makes a changed file's checksum right again: 64-bit FNV-1a, as its specification has it.
    static void seal(Bytes& bytes) {
        std::uint64_t hash = 14695981039346656037u;
        for (std::size_t i = 0; i + 8 < bytes.size(); ++i) {
            hash ^= bytes[i];
            hash *= 1099511628211u;
        }
        for (std::size_t i = 0; i < 8; ++i)
            bytes[bytes.size() - 8 + i] = std::uint8_t(hash >> (8 * i));
    }

  private:
    const test::TempFolder temporary_;
    const fs::path folder_ = temporary_.path();
};

TEST_F(GuideFileTest, BringsEverythingBackToTheBit) {
    const GuideContext context = someContext();
    const SdTree grown = smallTree();
    ASSERT_GT(grown.cells().size(), 3u);
    const SdTree empty({0, 0, 0}, {1, 1, 1}, {});
    for (const SdTree* tree : {&grown, &empty}) {
        saveGuide(file(), *tree, context);
        LoadedGuide loaded = loadGuide(file());
        SdTree expected = *tree;
        for (GuideCell& cell : expected.cells())
            cell.changed = true; // nothing of it was published yet
        EXPECT_TRUE(same(loaded.tree, expected));
        EXPECT_EQ(loaded.tree.empty(), tree->empty());
        const SdTreeConfig &a = loaded.tree.config(), &b = tree->config();
        EXPECT_EQ(std::tie(a.cellRecords, a.directionShare, a.forgetting, a.maxQuadDepth, a.maxSpatialDepth, a.maxNodes),
                  std::tie(b.cellRecords, b.directionShare, b.forgetting, b.maxQuadDepth, b.maxSpatialDepth, b.maxNodes));
        EXPECT_EQ(loaded.context.geometry, context.geometry);
        EXPECT_EQ(loaded.context.parameters, context.parameters);
        EXPECT_EQ(loaded.context.reference, context.reference);
        for (const auto& [now, then] :
             {std::pair(loaded.context.figures, context.figures), std::pair(loaded.context.rouletteFigures, context.rouletteFigures)}) {
            ASSERT_EQ(now.size(), then.size());
            for (const auto& [kind, f] : then) {
                ASSERT_TRUE(now.contains(kind));
                EXPECT_EQ(now.at(kind).variance, f.variance);
                EXPECT_EQ(now.at(kind).rays, f.rays);
                EXPECT_EQ(now.at(kind).passes, f.passes);
            }
        }
        const Bytes first = readFile(file());
        saveGuide(file(), loaded.tree, loaded.context);
        EXPECT_EQ(readFile(file()), first);
        // It learns on as the one that was saved.
        const std::vector<CellRecords> more = place(expected, randomSamples(tree->lower(), tree->upper(), 2000, 9));
        expected.update(more);
        loaded.tree.update(more);
        EXPECT_TRUE(same(loaded.tree, expected));
    }
}

TEST_F(GuideFileTest, RefusesEveryPrefix) {
    saveGuide(file(), smallTree(1500), someContext());
    const Bytes whole = readFile(file());
    ASSERT_LT(whole.size(), 50'000u) << "or this test takes long";
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const std::string message = refusal(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size)));
        ASSERT_TRUE(contains(message, size < 8 ? "is no guide" : "is truncated")) << size << ": " << message;
    }
    Bytes longer = whole;
    longer.push_back(0);
    EXPECT_TRUE(contains(refusal(longer), "after its end"));
    EXPECT_EQ(refusal(whole), "");
}

TEST_F(GuideFileTest, RefusesEveryPrefixOfTheContents) {
    saveGuide(file(), smallTree(5000), someContext());
    const Bytes whole = readFile(file());
    constexpr std::size_t kFrame = 20 + 8; // header and checksum
    for (std::size_t size = 0; size + kFrame < whole.size(); ++size) {
        Bytes bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size + kFrame));
        for (std::size_t i = 0; i < 8; ++i)
            bytes[12 + i] = std::uint8_t(std::uint64_t(size) >> (8 * i));
        seal(bytes);
        const std::string message = refusal(bytes);
        ASSERT_TRUE(contains(message, "is no valid guide")) << size << ": " << message;
    }
}

TEST_F(GuideFileTest, RefusesFlippedBits) {
    saveGuide(file(), smallTree(), someContext());
    const Bytes whole = readFile(file());
    std::mt19937 random(1);
    for (int i = 0; i < 2000; ++i) {
        Bytes bytes = whole;
        bytes[random() % bytes.size()] ^= std::uint8_t(1u << (random() % 8));
        ASSERT_NE(refusal(bytes), "");
    }
}

// With the checksum made right: refused, or a tree in which everything holds and that can go on learning.
TEST_F(GuideFileTest, SurvivesHostileContents) {
    saveGuide(file(), smallTree(5000), someContext());
    const Bytes whole = readFile(file());
    std::mt19937 random(2);
    int taken = 0, refused = 0;
    for (int i = 0; i < 4000; ++i) {
        Bytes bytes = whole;
        for (int n = 0; n < 1 + i % 3; ++n)
            bytes[random() % (bytes.size() - 8)] = i % 2 ? std::uint8_t(random()) : std::uint8_t(-int(random() % 2));
        seal(bytes);
        if (!refusal(bytes).empty()) {
            ++refused;
            continue;
        }
        ++taken;
        LoadedGuide loaded = loadGuide(file());
        loaded.tree.update(place(loaded.tree, randomSamples(loaded.tree.lower(), loaded.tree.upper(), 1000, std::uint32_t(i))));
        ASSERT_EQ(loaded.tree.validate(), "");
    }
    EXPECT_GT(taken, 100);
    EXPECT_GT(refused, 100);
}

TEST_F(GuideFileTest, SaysWhatIsWrong) {
    saveGuide(file(), smallTree(), someContext());
    const Bytes whole = readFile(file());
    Bytes bytes = whole;
    bytes[8] = 3;
    EXPECT_TRUE(contains(refusal(bytes), "of version 3, not 2"));
    seal(bytes);
    EXPECT_TRUE(contains(refusal(bytes), "of version 3, not 2"));
    bytes = whole;
    bytes[whole.size() / 2] ^= 1;
    EXPECT_TRUE(contains(refusal(bytes), "checksum"));
    EXPECT_TRUE(contains(refusal({'g', 'l', 'T', 'F', 2, 0, 0, 0, 1, 2, 3, 4}), "is no guide"));
    fs::remove(file());
    EXPECT_THROW(loadGuide(file()), Error);
}

TEST_F(GuideFileTest, SaysWhenItCannotBeWritten) {
    const fs::path inTheWay = file();
    fs::create_directories(inTheWay / "folder");
    try {
        saveGuide(inTheWay, smallTree(), {});
        FAIL() << "a folder was overwritten";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Output);
    }
    std::size_t entries = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(inTheWay.parent_path()))
        ++entries;
    EXPECT_EQ(entries, 1u) << "something was left aside";
}

} // namespace
} // namespace cmpg
