// The stream of images to a display: what arrives, and that nobody waits for a bad one.
#include "imaging/display_stream.h"

#include "base/error.h"
#include "support/temp_folder.h"

#include <algorithm>
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <mutex>
#include <netinet/in.h>
#include <optional>
#include <poll.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace cmpg::test {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// A display: reads packets as docs/display-stream.md describes them, written from that page alone.
class Receiver {
  public:
    struct Shown {
        Image image;
        int creations = 0, updates = 0;
    };
    // Reads about `bytesPerSecond`; hangs up after `hangUpAfter` packets.
    explicit Receiver(double bytesPerSecond = 1e12, int hangUpAfter = -1, std::uint16_t port = 0) : rate_(bytesPerSecond), hangUp_(hangUpAfter) {
        listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        const int yes = 1;
        ::setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        const int small = 1 << 16;
        ::setsockopt(listening_, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
        sockaddr_in a{};
        a.sin_family = AF_INET;
        a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        a.sin_port = htons(port);
        EXPECT_EQ(::bind(listening_, reinterpret_cast<sockaddr*>(&a), sizeof a), 0);
        socklen_t size = sizeof a;
        ::getsockname(listening_, reinterpret_cast<sockaddr*>(&a), &size);
        port_ = ntohs(a.sin_port);
        ::listen(listening_, 4);
        thread_ = std::thread([this] { run(); });
    }
    ~Receiver() {
        over_ = true;
        thread_.join();
        ::close(listening_);
    }
    std::uint16_t port() const { return port_; }
    std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
    std::map<std::string, Shown> shown() {
        const std::lock_guard lock(mutex_);
        return shown_;
    }
    int connections() const { return connections_; }
    bool malformed() const { return malformed_; }
    bool await(const std::function<bool(const std::map<std::string, Shown>&)>& wanted, double seconds = 20) {
        for (const auto start = Clock::now(); since(start) < seconds; std::this_thread::sleep_for(std::chrono::milliseconds(5)))
            if (wanted(shown()))
                return true;
        return false;
    }

  private:
    bool readable(int descriptor) const {
        while (!over_) {
            pollfd p{descriptor, POLLIN, 0};
            if (::poll(&p, 1, 20) > 0)
                return true;
        }
        return false;
    }
    bool read(int descriptor, void* to, std::size_t bytes) {
        auto* at = static_cast<char*>(to);
        while (bytes > 0) {
            if (!readable(descriptor))
                return false;
            const std::size_t part = std::min<std::size_t>(bytes, 1 << 14);
            const ssize_t n = ::recv(descriptor, at, part, 0);
            if (n <= 0)
                return false;
            at += n;
            bytes -= std::size_t(n);
            for (const auto start = Clock::now(); rate_ < 1e9 && since(start) < double(n) / rate_ && !over_;)
                std::this_thread::sleep_for(std::chrono::duration<double>(std::min(0.05, double(n) / rate_)));
        }
        return true;
    }
    void run() {
        while (!over_) {
            if (!readable(listening_))
                return;
            const int connection = ::accept(listening_, nullptr, nullptr);
            ++connections_;
            for (int packets = 0; packets != hangUp_; ++packets) {
                std::uint32_t length = 0;
                if (!read(connection, &length, 4))
                    break;
                std::vector<char> packet(length < 5 ? 0 : length - 4);
                if (length < 5 || !read(connection, packet.data(), packet.size()))
                    break;
                take(packet);
            }
            hangUp_ = -1;
            ::close(connection);
        }
    }
    void take(const std::vector<char>& packet) {
        const char* at = packet.data();
        const auto number = [&]<class T>(T) {
            T v;
            std::memcpy(&v, at, sizeof v);
            at += sizeof v;
            return v;
        };
        const auto text = [&] {
            std::string s = at;
            at += s.size() + 1;
            return s;
        };
        const int type = number(std::uint8_t());
        number(std::uint8_t());
        const std::string name = text();
        int width = 0, height = 0;
        if (type == 4) {
            width = number(std::int32_t());
            height = number(std::int32_t());
        }
        const int channels = number(std::int32_t());
        std::string names;
        for (int c = 0; c < channels; ++c)
            names += text();
        malformed_ = malformed_ || (names != "RGB" && names != "Y");
        const std::lock_guard lock(mutex_);
        Shown& s = shown_[name];
        if (type == 4) {
            s.image = Image(width, height, channels, -1);
            ++s.creations;
        } else {
            const int x = number(std::int32_t()), y = number(std::int32_t()), w = number(std::int32_t()), h = number(std::int32_t());
            std::vector<std::int64_t> offset, stride;
            for (int c = 0; c < channels; ++c)
                offset.push_back(number(std::int64_t()));
            for (int c = 0; c < channels; ++c)
                stride.push_back(number(std::int64_t()));
            std::vector<float> values(std::size_t(packet.data() + packet.size() - at) / 4);
            std::memcpy(values.data(), at, 4 * values.size());
            for (int j = 0; j < h; ++j)
                for (int i = 0; i < w; ++i)
                    for (int c = 0; c < channels; ++c)
                        s.image.at(x + i, y + j)[c] = values.at(std::size_t(offset[c] + (std::int64_t(j) * w + i) * stride[c]));
            at += 4 * values.size();
            ++s.updates;
        }
        malformed_ = malformed_ || at != packet.data() + packet.size() || (type != 4 && type != 6);
    }

    double rate_;
    int hangUp_;
    int listening_ = -1;
    std::uint16_t port_ = 0;
    std::atomic<bool> over_ = false, malformed_ = false;
    std::atomic<int> connections_ = 0;
    std::mutex mutex_;
    std::map<std::string, Shown> shown_;
    std::thread thread_;
};

Image ramp(int width, int height, int channels, float first) {
    Image image(width, height, channels);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = first + float(i);
    return image;
}

TEST(DisplayStream, ImagesArriveAsTheyAre) {
    Receiver display;
    const Image color = ramp(700, 400, 3, -50), grey = ramp(5, 3, 1, 0.5f), other = ramp(8, 9, 3, 1);
    {
        DisplayStream stream(display.address(), "run");
        EXPECT_TRUE(stream.active());
        stream.show("image", color);
        stream.show("gradient.wall.roughness", grey);
        EXPECT_TRUE(display.await([](const auto& all) { return all.size() == 2 && all.at("run/image").updates >= 4; }));
        stream.show("image", other); // of another size
    } // waits for it
    EXPECT_TRUE(display.await([&](const auto& all) { return all.at("run/image").image.values == other.values; }));
    const auto shown = display.shown();
    EXPECT_EQ(shown.at("run/gradient.wall.roughness").image.values, grey.values);
    EXPECT_EQ(shown.at("run/image").creations, 2);
    EXPECT_EQ(shown.at("run/image").updates, 5); // 3.4 MB in parts of a megabyte, and the small one
    EXPECT_FALSE(display.malformed());
}

TEST(DisplayStream, ASlowDisplayGetsTheLatestAndHoldsNobodyUp) {
    Receiver display(4e6);
    const auto start = Clock::now();
    {
        DisplayStream stream(display.address());
        for (int i = 0; i < 200; ++i) // 96 MB, for which this display would need 24 s
            stream.show("image", Image(200, 200, 3, float(i)));
        EXPECT_LT(since(start), 12);
        EXPECT_TRUE(display.await([](const auto& all) { return all.count("image") && all.at("image").image.values.back() == 199; }));
        EXPECT_LT(display.shown().at("image").updates, 100);
    }
    EXPECT_FALSE(display.malformed());
}

TEST(DisplayStream, ADisplayThatStopsReadingIsLeft) {
    Receiver display(1); // a byte a second
    const auto start = Clock::now();
    {
        DisplayStream stream(display.address());
        for (int i = 0; i < 20; ++i)
            stream.show("image" + std::to_string(i), Image(512, 512, 3, 1));
        EXPECT_LT(since(start), 10); // copies of 63 MB, on a machine however busy
    }
    EXPECT_LT(since(start), 15); // a second for what is left
}

TEST(DisplayStream, ADisplayThatHangsUpIsTriedAgain) {
    Receiver display(1e12, 3);
    DisplayStream stream(display.address());
    stream.show("first", ramp(4, 4, 3, 7));
    const auto start = Clock::now();
    for (int i = 0; display.connections() < 2 && since(start) < 20; ++i) {
        stream.show("second", Image(64, 64, 3, float(i)));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(display.connections(), 2);
    // The new connection is told everything again.
    EXPECT_TRUE(display.await([](const auto& all) { return all.count("first") && all.at("first").creations == 2 && all.count("second") && all.at("second").updates > 0; }));
    EXPECT_FALSE(display.malformed());
}

TEST(DisplayStream, AnAbsentDisplayMayComeLate) {
    std::uint16_t port = 0;
    {
        Receiver gone;
        port = gone.port();
    }
    testing::internal::CaptureStderr();
    const auto start = Clock::now();
    {
        DisplayStream stream("127.0.0.1:" + std::to_string(port));
        for (int i = 0; i < 50; ++i)
            stream.show("image", Image(64, 64, 3, 1));
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    EXPECT_LT(since(start), 10);
    const std::string warnings = testing::internal::GetCapturedStderr();
    const std::size_t first = warnings.find("display server");
    EXPECT_NE(first, std::string::npos) << warnings;
    EXPECT_EQ(warnings.find("display server", first + 1), std::string::npos) << warnings; // once

    DisplayStream stream("127.0.0.1:" + std::to_string(port));
    stream.show("image", Image(4, 4, 3, 1));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    Receiver late(1e12, -1, port);
    EXPECT_TRUE(late.await([](const auto& all) { return all.count("image") && all.at("image").updates == 1; }));
}

TEST(DisplayStream, AddressesAreChecked) {
    for (const char* good : {"localhost", "localhost:14158", "10.0.0.1:1", "[::1]:65535", "[::1]"})
        EXPECT_NO_THROW(DisplayStream::requireAddress(good)) << good;
    for (const char* bad : {"", ":14158", "localhost:", "localhost:0", "localhost:65536", "localhost:tev", "localhost:12x", "[::1", "[]:5", "a:1:2"})
        EXPECT_THROW(DisplayStream::requireAddress(bad), Error) << bad;
    EXPECT_FALSE(DisplayStream("").active());
}

// The program itself.
TEST(DisplayStream, CommandsShowWhatTheyWrite) {
    const test::TempFolder folder;
    const auto run = [&](const std::string& rest) {
        return std::system((std::string(CMPG_BINARY) + " --headless --quiet --width 32 --height 32 --max-depth 4 " + rest + " >/dev/null 2>&1").c_str());
    };
    const std::string scene = std::string(CMPG_SOURCE_DIR) + "/scenes/box/scene.gltf ", out = folder / "";
    Receiver display;
    const std::string stream = " --display-server " + display.address();
    EXPECT_EQ(run("render " + scene + "--spp 19 --layers " + out + "a-layers.exr -o " + out + "a.exr" + stream), 0);
    EXPECT_EQ(run("render " + scene + "--spp 19 --layers " + out + "b-layers.exr -o " + out + "b.exr"), 0);
    EXPECT_EQ(readImage(out + "a.exr").image.values, readImage(out + "b.exr").image.values);
    EXPECT_EQ(readImage(out + "a-layers.exr", {.layer = "albedo"}).image.values, readImage(out + "b-layers.exr", {.layer = "albedo"}).image.values);
    EXPECT_TRUE(display.await([&](const auto& all) { return all.count("a/image") && all.at("a/image").image.values == readImage(out + "a.exr").image.values; }));
    EXPECT_EQ(run("gradient " + scene + "--spp 7 --param painting.baseColor -o " + out + "g.exr" + stream), 0);
    EXPECT_TRUE(display.await([&](const auto& all) { return all.count("g/gradient") && all.at("g/gradient").image.values == readImage(out + "g.exr").image.values; }));
    EXPECT_EQ(run("optimize " + scene + "--spp 2 --steps 2 --param painting.baseColor --set painting.baseColor=0.5 --target " + out + "a.exr -o " + out + "run/" + stream), 0);
    EXPECT_TRUE(display.await([&](const auto& all) {
        return all.count("run/image") && all.count("run/gradient.painting.baseColor") && all.count("run/painting.baseColor") &&
               all.at("run/painting.baseColor").image.values == readImage(out + "run/parameters/painting.baseColor.exr").image.values;
    }));
    // The name of a folder has no ending.
    EXPECT_EQ(run("optimize " + scene + "--spp 1 --steps 1 --param painting.baseColor --target " + out + "a.exr -o " + out + "run0.5/" + stream), 0);
    EXPECT_TRUE(display.await([](const auto& all) { return all.count("run0.5/image"); }));
    EXPECT_FALSE(display.malformed());
}

} // namespace
} // namespace cmpg::test
