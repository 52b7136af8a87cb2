#include "vk/driver_threads.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace cmpg {
namespace {

// Until threads have their names; longer than a busy machine takes.
constexpr int kRounds = 40;
constexpr std::chrono::microseconds kWait(500);

// In the order in which they were started, as Linux lists them.
std::vector<int> threadsOfProcess() {
    std::vector<int> threads;
    std::error_code failed; // no /proc: none
    for (auto entry = std::filesystem::directory_iterator("/proc/self/task", failed); !failed && entry != std::filesystem::directory_iterator();
         entry.increment(failed)) {
        const std::string name = entry->path().filename();
        int id = 0;
        if (std::from_chars(name.data(), name.data() + name.size(), id).ec == std::errc())
            threads.push_back(id);
    }
    return threads;
}

std::string nameOf(int thread) {
    std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/comm");
    std::string name;
    std::getline(file, name);
    return name;
}

} // namespace

std::uint32_t processorsAllowed() {
    cpu_set_t allowed;
    const bool known = sched_getaffinity(0, sizeof allowed, &allowed) == 0; // not with more processors than the set holds
    return std::max(1u, known ? std::uint32_t(CPU_COUNT(&allowed)) : std::thread::hardware_concurrency());
}

DriverThreads::DriverThreads() : before_(threadsOfProcess()) {}

void DriverThreads::spread(std::uint32_t workers) const {
    cpu_set_t allowed;
    if (workers < 2 || sched_getaffinity(0, sizeof allowed, &allowed) != 0 || std::uint32_t(CPU_COUNT(&allowed)) != workers)
        return;
    // The driver names the threads that rasterise and those of its cache, each once it runs; those that compute keep the name of the thread that started them,
    // this one, as does that of the device's queue, the first of them.
    const std::string own = nameOf(gettid());
    std::vector<int> unnamed;
    for (int round = 0; round < kRounds; ++round) {
        unnamed.clear();
        for (const int thread : threadsOfProcess())
            if (std::find(before_.begin(), before_.end(), thread) == before_.end() && nameOf(thread) == own)
                unnamed.push_back(thread);
        if (unnamed.size() <= workers + 1)
            break;
        std::this_thread::sleep_for(kWait);
    }
    if (unnamed.size() != workers + 1)
        return;
    unnamed.erase(unnamed.begin());
    int processor = 0;
    for (const int thread : unnamed) {
        while (!CPU_ISSET(processor, &allowed))
            ++processor;
        cpu_set_t one;
        CPU_ZERO(&one);
        CPU_SET(processor++, &one);
        sched_setaffinity(thread, sizeof one, &one); // a refusal leaves things as they were
    }
}

} // namespace cmpg
