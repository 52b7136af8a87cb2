// Devices that ranks share.
#include "library_fixture.h"
#include "support/thread_ranks.h"

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

} // namespace
} // namespace cmpg::test
