// Devices that ranks share.
#include "library_fixture.h"
#include "support/thread_ranks.h"

#include <limits>
#include <thread>

namespace cmpg::test {
namespace {

// What each of `count` ranks, threads with devices of their own, makes of a device.
template <class Make> auto onRanks(int count, Make&& make) {
    ThreadRank::Table table(count);
    std::vector<decltype(make(std::declval<Device&>()))> results(static_cast<std::size_t>(count));
    std::vector<std::thread> threads;
    for (int r = 0; r < count; ++r)
        threads.emplace_back([&, r] {
            Device shared({}, std::make_shared<ThreadRank>(table, r));
            results[std::size_t(r)] = make(shared);
        });
    for (std::thread& thread : threads)
        thread.join();
    return results;
}

TEST(LibraryRanks, ShareWhatOneMakes) {
    const Target target = smallTarget();
    const auto work = [&](Device& on) {
        Renderer renderer(on, greyScene(), {.paths = {.maxDepth = 4}, .parameters = {kPainting}});
        std::vector<std::vector<double>> found = renderer.backward(target.image, {.spp = 8, .train = 1});
        PassOptions pass{.width = 40, .spp = 4};
        std::size_t shown = 0;
        pass.onImage = [&](const Image&) { ++shown; };
        const Image image = renderer.render(pass);
        EXPECT_GE(shown, 1u);
        found.emplace_back(image.values.begin(), image.values.end());
        Recovery recovery(on, greyScene(), {target}, paintingOptions());
        found.push_back({recovery.step().loss, recovery.step().loss});
        const std::vector<float> values = recovery.values(kPainting);
        found.emplace_back(values.begin(), values.end());
        return found;
    };
    const auto alone = work(device());
    for (const auto& found : onRanks(2, work))
        EXPECT_EQ(found, alone);
}

TEST(LibraryRanks, RefuseToShareDifferentThings) {
    const auto refused = onRanks(2, [](Device& on) {
        static std::atomic<int> number;
        const float mine = 0.1f * float(++number);
        std::vector<std::string> errors;
        const auto attempt = [&](auto&& call) {
            try {
                call();
            } catch (const Error& error) {
                EXPECT_EQ(error.kind, ErrorKind::Usage);
                errors.push_back(error.what());
            }
        };
        Scene scene = greyScene();
        Renderer renderer(on, scene, {.parameters = {kPainting}});
        const Image image = renderer.render({.width = 8, .spp = 1});
        attempt([&] { renderer.render({.width = 8, .timeBudget = 1}); });
        scene.set(kPainting, std::vector{mine});
        attempt([&] { renderer.render({.width = 8, .spp = 1}); });
        attempt([&] { Recovery(on, scene, {{"", image}}, paintingOptions()); });
        return errors;
    });
    for (const std::vector<std::string>& errors : refused)
        EXPECT_EQ(errors, (std::vector<std::string>{"a time budget does not run on several ranks", "rank 1 has asked for another pass than rank 0",
                                                    "rank 1 recovers something else than rank 0"}));
}

// Whatever is wrong on one of two ranks alone: none waits for the other, and both go on together.
TEST(LibraryRanks, HearOfWhatIsWrongOnOneOfThem) {
    const Target target = smallTarget();
    std::atomic<int> number = 0;
    const auto found = onRanks(2, [&](Device& on) {
        const bool wrong = number++ == 0;
        std::vector<std::string> errors;
        const auto attempt = [&](auto&& call) { errors.push_back(errorOf(call).what()); };
        Renderer renderer(on, greyScene(), {.parameters = {kPainting}});
        Image adjoint = target.image;
        if (wrong)
            adjoint.values[5] = std::numeric_limits<float>::quiet_NaN();
        attempt([&] { renderer.backward(adjoint, {.spp = 1}); });
        attempt([&] { renderer.render({.camera = wrong ? "nobody's" : "", .width = 8, .spp = 1}); });
        attempt([&] { renderer.train({.width = wrong ? -1 : 8, .spp = 1, .train = 1}); });
        const std::vector<Direction> directions{{kPainting, std::vector<float>(wrong ? 1 : 64 * 64 * 3)}};
        attempt([&] { renderer.forward(directions, {.width = 8, .spp = 1}); });
        Film film(8, 8);
        attempt([&] { renderer.render(film, {.width = wrong ? 9 : 8, .spp = 1}); });
        RecoveryOptions options = paintingOptions();
        options.parameters = {wrong ? "nothing" : kPainting};
        attempt([&] { Recovery(on, greyScene(), {target}, options); });
        options = paintingOptions();
        options.prior = wrong ? -1.0f : 0.0f;
        attempt([&] { Recovery(on, greyScene(), {target}, options); });
        Recovery recovery(on, greyScene(), {target}, paintingOptions());
        attempt([&] { recovery.image(wrong ? 1 : 0, 1); });
        recovery.setRateFactor(wrong ? 0.5 : 1);
        attempt([&] { recovery.step(); });
        recovery.setRateFactor(1);
        recovery.setSamples(wrong ? 1 : 2, 4);
        attempt([&] { recovery.step(); });
        recovery.setSamples(2, 4);
        if (wrong)
            attempt([&] { recovery.step(), recovery.step(); }); // the other one asks for its image
        else
            attempt([&] { recovery.step(), recovery.image(0, 1); });
        return std::pair(errors, recovery.step().loss);
    });
    EXPECT_EQ(found[0].second, found[1].second);
    EXPECT_EQ(found[0].first.size(), found[1].first.size());
    for (std::size_t i = 0; i < found[0].first.size(); ++i) {
        const std::string &a = found[0].first[i], &b = found[1].first[i];
        if (i < 8) {
            const bool first = a.find("was refused: ") == std::string::npos; // of the two, what is wrong with it
            EXPECT_TRUE((first ? b : a).ends_with(" of 2 was refused: " + (first ? a : b))) << a << '\n' << b;
        } else {
            EXPECT_EQ(a, "rank 1 is not in the same place of its recovery, or has asked for something else there, than rank 0");
            EXPECT_EQ(a, b);
        }
    }
}

// The others cannot go on with the device where the work itself has ended.
TEST(LibraryRanks, TellWhatEndsTheirWork) {
    class Listening final : public Communicator {
      public:
        explicit Listening(ThreadRank::Table& table) : rank_(table, 0) {}
        int rank() const override { return 0; }
        int size() const override { return 2; }
        int localRank() const override { return 0; }
        int localSize() const override { return 1; }
        void sum(std::span<std::int64_t> values) override { rank_.sum(values); }
        void broadcast(std::span<std::byte> bytes, int root) override { rank_.broadcast(bytes, root); }
        void gatherInto(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
            for (std::size_t at = 0; at < all.size(); at += own.size()) // the other one says the same
                std::copy(own.begin(), own.end(), all.begin() + std::ptrdiff_t(at));
            EXPECT_EQ(sizes.size(), 2u);
        }
        void passFailed(const std::string& why) noexcept override { told = why; }
        std::string told;

      private:
        ThreadRank rank_;
    };
    ThreadRank::Table table(1);
    const auto listening = std::make_shared<Listening>(table);
    Device on({}, listening);
    for (const bool alone : {false, true}) {
        Renderer renderer(on, greyScene(), {.paths = {.maxDepth = 64, .memory = 16}});
        listening->told.clear();
        const Error error = errorOf([&] {
            if (alone)
                renderer.train({.width = 8, .spp = 1, .train = 1});
            else
                renderer.render({.width = 8, .spp = 1});
        });
        EXPECT_NE(std::string(error.what()).find("does not hold one batch"), std::string::npos) << error.what();
        EXPECT_EQ(listening->told, error.what());
    }
}

} // namespace
} // namespace cmpg::test
