// Sends images to a display from a thread of its own: the latest of each name, in whatever time the display takes.
#include "imaging/display_stream.h"

#include "base/error.h"
#include "base/log.h"
#include "imaging/display_packets.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <map>
#include <mutex>
#include <netdb.h>
#include <poll.h>
#include <set>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace cmpg {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kRetry = std::chrono::seconds(2);   // between attempts to connect
constexpr auto kConnect = std::chrono::seconds(2); // for one of them
constexpr auto kFarewell = std::chrono::seconds(1); // for the last images, once the run is over
constexpr std::size_t kPacketBytes = std::size_t(1) << 20; // about; a packet holds a row at least

struct Address {
    std::string host, port = "14158";
};

Address parseAddress(const std::string& text) {
    const auto refuse = [&] {
        return Error(ErrorKind::Usage, "--display-server takes HOST:PORT, not '" + text + "'", "", "for example --display-server localhost:14158");
    };
    Address address;
    std::string rest;
    if (!text.empty() && text[0] == '[') {
        const std::size_t end = text.find(']');
        if (end == std::string::npos)
            throw refuse();
        address.host = text.substr(1, end - 1);
        rest = text.substr(end + 1);
    } else {
        const std::size_t colon = text.find(':');
        address.host = text.substr(0, colon);
        rest = colon == std::string::npos ? "" : text.substr(colon);
    }
    if (!rest.empty()) {
        unsigned port = 0;
        const char* const end = rest.data() + rest.size();
        const auto [stop, error] = std::from_chars(rest.data() + 1, end, port);
        if (rest[0] != ':' || error != std::errc() || stop != end || port == 0 || port > 65535)
            throw refuse();
        address.port = std::to_string(port);
    }
    if (address.host.empty())
        throw refuse();
    return address;
}

class Socket {
  public:
    explicit Socket(int descriptor = -1) : descriptor_(descriptor) {}
    ~Socket() {
        if (descriptor_ >= 0)
            ::close(descriptor_);
    }
    Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    Socket& operator=(Socket&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    int get() const { return descriptor_; }
    explicit operator bool() const { return descriptor_ >= 0; }

  private:
    int descriptor_;
};

} // namespace

struct DisplayStream::Impl {
    const Address address;
    const std::string title;
    std::mutex mutex;
    std::condition_variable condition;
    std::map<std::string, std::shared_ptr<const Image>> latest; // all there ever was, for a display that comes late
    std::set<std::string> waiting;                              // of these, not sent yet
    bool over = false;
    Clock::time_point end = Clock::time_point::max();

    // The thread's own.
    Socket socket;
    std::map<std::string, std::array<int, 3>> created; // shapes that the display knows
    bool warned = false;
    std::thread thread;

    Impl(Address a, std::string t) : address(std::move(a)), title(std::move(t)), thread([this] { run(); }) {}
    ~Impl() {
        {
            const std::lock_guard lock(mutex);
            over = true;
            end = Clock::now() + kFarewell;
        }
        condition.notify_one();
        thread.join();
    }

    static constexpr const char* kGoesOn = "; the run goes on without it, and tries again now and then";

    void warn(const std::string& what) {
        if (!std::exchange(warned, true))
            logWarn("display server " + address.host + ":" + address.port + ": " + what);
    }

    // When to give up: at once when the run has ended long enough ago.
    Clock::time_point deadline() {
        const std::lock_guard lock(mutex);
        return end;
    }

    // Waits until the socket can be written to. False: an error, or it is too late.
    bool writable(int descriptor, Clock::time_point until) {
        while (Clock::now() < std::min(until, deadline())) {
            pollfd p{descriptor, POLLOUT, 0};
            const int ready = ::poll(&p, 1, 50);
            if (ready > 0)
                return (p.revents & (POLLERR | POLLHUP | POLLNVAL)) == 0;
            if (ready < 0 && errno != EINTR)
                return false;
        }
        return false;
    }

    void connect() {
        addrinfo hints{};
        hints.ai_socktype = SOCK_STREAM;
        addrinfo* found = nullptr;
        if (const int error = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0)
            return warn(gai_strerror(error) + std::string(kGoesOn));
        const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> all(found, &::freeaddrinfo);
        std::string cause = "nobody answers";
        for (const addrinfo* a = found; a && !socket; a = a->ai_next) {
            Socket s(::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol));
            if (!s)
                continue;
            int error = ::connect(s.get(), a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
            if (error == EINPROGRESS) {
                const bool answered = writable(s.get(), Clock::now() + kConnect);
                socklen_t size = sizeof error;
                ::getsockopt(s.get(), SOL_SOCKET, SO_ERROR, &error, &size);
                if (!answered && error == 0)
                    continue;
            }
            if (error == 0)
                socket = std::move(s);
            else
                cause = std::strerror(error);
        }
        if (!socket)
            return warn(cause + kGoesOn);
        const std::lock_guard lock(mutex);
        for (const auto& [name, image] : latest)
            waiting.insert(name);
    }

    void disconnect() {
        socket = Socket();
        created.clear();
    }

    bool send(const Packet& packet) {
        for (std::size_t sent = 0; sent < packet.size();) {
            const ssize_t n = ::send(socket.get(), packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
            if (n > 0)
                sent += std::size_t(n);
            else if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
                return false;
            else if (!writable(socket.get(), Clock::time_point::max()))
                return false;
        }
        return true;
    }

    bool send(const std::string& name, const Image& image) {
        const std::string full = title.empty() ? name : title + "/" + name;
        const std::array shape{image.width, image.height, image.channels};
        if (const auto known = created.find(name); known == created.end() || known->second != shape) {
            if (!send(createPacket(full, image)))
                return false;
            created[name] = shape;
        }
        const int rows = std::max(1, int(kPacketBytes / (std::size_t(image.width) * image.channels * sizeof(float))));
        for (int y = 0; y < image.height; y += rows)
            if (!send(updatePacket(full, image, y, std::min(rows, image.height - y))))
                return false;
        return true;
    }

    void run() {
        Clock::time_point nextTry{};
        for (;;) {
            std::string name;
            std::shared_ptr<const Image> image;
            {
                std::unique_lock lock(mutex);
                condition.wait(lock, [&] { return over || !waiting.empty(); });
                if (waiting.empty() || Clock::now() >= end)
                    return;
                if (!socket && Clock::now() < nextTry) {
                    if (over)
                        return; // there was nobody a moment ago
                    condition.wait_until(lock, nextTry, [&] { return over; });
                    continue;
                }
                if (socket) {
                    name = *waiting.begin();
                    waiting.erase(waiting.begin());
                    image = latest[name];
                }
            }
            if (!image) {
                connect();
                nextTry = Clock::now() + kRetry;
            } else if (!send(name, *image)) {
                disconnect();
                nextTry = Clock::now() + kRetry;
                warn(Clock::now() < deadline() ? "the connection was closed" + std::string(kGoesOn) : "too slow for the last images");
            }
        }
    }
};

DisplayStream::DisplayStream(const std::string& address, const std::string& title) {
    if (!address.empty())
        impl_ = std::make_unique<Impl>(parseAddress(address), title);
}

DisplayStream::~DisplayStream() = default;

void DisplayStream::requireAddress(const std::string& address) { parseAddress(address); }

void DisplayStream::show(const std::string& name, const Image& image) {
    if (!impl_ || image.pixels() == 0)
        return;
    auto copy = std::make_shared<const Image>(image);
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->latest[name] = std::move(copy);
        impl_->waiting.insert(name);
    }
    impl_->condition.notify_one();
}

} // namespace cmpg
