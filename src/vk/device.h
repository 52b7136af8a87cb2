// A Vulkan compute device: choice, limits, buffers, kernels, submission, timestamps, memory accounting.
// No Vulkan type appears here; src/vk/*.cpp alone includes the Vulkan headers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cmpg {

// Storage buffers that a kernel binds at most, in its full and in its portable variant: what a device must allow. Texel buffers of the full
// variant, 13 at most, are within what every device allows; the variant for CPUs binds some of these as storage texel buffers, and queues too.
constexpr std::uint32_t kStorageBuffers = 20, kStorageBuffersPortable = 28, kStorageTexelBuffers = 20;

// How kernels read their tables, and with what they sum: see cmake/Shaders.cmake.
enum class KernelVariant { Full, Cpu, Portable };

struct DeviceInfo {
    std::string name;   // as the driver reports it
    std::string driver; // driver name and version
    std::string type;   // "cpu", "integrated", "discrete", "virtual", "other"
    bool usable = true;
    std::string missing; // why it is not usable: the required features it lacks
    bool int64Atomics = false, float64 = false;
    KernelVariant variant = KernelVariant::Full; // of the kernels; Portable where it lacks what the others take
    std::uint32_t subgroupSize = 0;
    std::uint64_t maxStorageBufferRange = 0;  // bytes
    std::uint64_t maxTexelBufferElements = 0; // elements
};

// What a buffer's memory is accounted to. Transient memory is what --memory bounds, Guide what --guide-memory bounds; the others are
// added and printed.
enum class MemoryKind { Scene, Parameters, Transient, Guide };

// Texel view of a buffer. Read-mostly hot data is read through it (twice as fast as storage on lavapipe).
enum class Texel { None, Rgba32f, Rgba32ui, R32f, R32ui };

struct MemoryUse {
    std::uint64_t current = 0, peak = 0;                    // bytes over all kinds
    std::map<std::string, std::uint64_t> buffers;           // live buffers by name
    std::array<std::uint64_t, 4> byKind{}, peakByKind{};    // indexed by MemoryKind
};

struct KernelTime {
    std::uint64_t calls = 0;
    double seconds = 0; // device time from timestamps, of the calls that were timed
};

class Device {
  public:
    struct Options {
        std::string select;      // "" = best usable; otherwise an index of list() or a part of the name, case-insensitive
        bool validation = false; // Vulkan validation layers; every message becomes an Error (also enabled by CMPG_VALIDATION=1)
        bool portable = false;   // use the portable kernel variants even where the device has more (also by CMPG_PORTABLE=1)
    };
    // Every Vulkan device seen, usable or not. Throws Error(Device) naming the remedy when there is no Vulkan at all.
    static std::vector<DeviceInfo> list();

    explicit Device(const Options& options); // Error(Device): none is usable or meant, or it computes wrong results (vk/self_test.h)
    ~Device();
    Device(Device&&) noexcept;

    const DeviceInfo& info() const;
    KernelVariant variant() const;
    bool portable() const;             // kernels read through storage buffers, no 64-bit atomics
    std::uint32_t driverThreads() const; // lavapipe: number of worker threads (static work split); 1 on GPUs
    const MemoryUse& memory() const;
    const std::map<std::string, KernelTime>& kernelTimes() const;
    double compileSeconds() const; // time spent creating pipelines and in their warm-up dispatch
    const std::map<std::string, double>& compileTimes() const; // the warm-up dispatches alone, helpers' included, by kernel: there a CPU driver compiles
    // Whether commands recorded from now on time their kernels. On lavapipe a timestamp takes 20 us, twice as long as a small dispatch.
    void timeKernels(bool on);
    bool timesKernels() const; // false at first
    void resetKernelTimes();
    void keepKernels(); // that are made from now on, until the device goes, and not only as long as somebody has them

    struct Impl;
    Impl& impl() const { return *impl_; }

  private:
    std::unique_ptr<Impl> impl_;
};

class Buffer {
  public:
    Buffer() noexcept; // null: binds as a 16-byte dummy
    // Size is rounded up to 16 bytes; contents start zeroed. Host transfers go through upload/download whatever the memory type.
    Buffer(Device& device, std::string name, std::uint64_t bytes, MemoryKind kind, Texel texel = Texel::None);
    ~Buffer();
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) noexcept;

    std::uint64_t size() const;
    explicit operator bool() const { return impl_ != nullptr; }

    // Must not be called while a submission that uses the buffer is in flight. What is uploaded is copied at once; to a discrete device it goes with the
    // next submission, or before the next download.
    void upload(std::span<const std::byte> bytes, std::uint64_t offset = 0);
    void download(std::span<std::byte> bytes, std::uint64_t offset = 0) const;
    template <class T> void uploadAll(const std::vector<T>& v, std::uint64_t offset = 0) { upload(std::as_bytes(std::span(v)), offset); }
    template <class T> std::vector<T> downloadAll(std::size_t count, std::uint64_t offset = 0) const {
        std::vector<T> v(count);
        download(std::as_writable_bytes(std::span(v)), offset);
        return v;
    }

    struct Impl;
    Impl* impl() const { return impl_.get(); }

  private:
    std::unique_ptr<Impl> impl_;
};

// Part of a buffer, for the host.
struct Download {
    const Buffer* from; // all of one device
    std::span<std::byte> to;
    std::uint64_t offset = 0; // bytes
};
// Several at once, which takes a discrete device hardly longer than one.
void download(std::span<const Download> downloads);

// When kernels are wanted: by somebody who waits for them, or later, so that warmUp() has as many processors as it can use.
enum class Wanted { Now, Later };

// One compute pipeline. Bindings and push-constant size are read from the SPIR-V, nothing is typed twice. Kernels whose code is the same after
// specialization share one.
class Kernel {
  public:
    Kernel() noexcept;
    // `name`: file name of the kernel without .comp. `constants[i]` is specialization constant id i (uint, float bits or bool).
    Kernel(Device& device, std::string_view name, std::span<const std::uint32_t> constants = {});
    ~Kernel();
    Kernel(Kernel&&) noexcept;
    Kernel& operator=(Kernel&&) noexcept;

    const std::string& name() const;
    std::uint32_t localSize() const; // invocations per workgroup
    Kernel copyFor(Device& device) const; // of the same driver

    struct Impl;
    Impl* impl() const { return impl_.get(); }

  private:
    friend std::vector<Kernel> makeKernels(Device&, std::span<const struct KernelRequest>, Wanted);
    std::shared_ptr<Impl> impl_;
};

struct KernelRequest {
    std::string_view name;
    std::span<const std::uint32_t> constants;
};
// Several, side by side. From any thread, as the constructor of Kernel.
std::vector<Kernel> makeKernels(Device& device, std::span<const KernelRequest> requests, Wanted wanted = Wanted::Now);

// Which buffer stands behind each binding number (shaders/shared/bindings.h). A kernel picks those it declares.
class Bindings {
  public:
    struct Range {
        const Buffer* buffer = nullptr;
        std::uint64_t offset = 0, bytes = 0; // bytes 0 = to the end; offset a multiple of 256
    };
    Bindings& set(std::uint32_t binding, const Buffer& buffer, std::uint64_t offset = 0, std::uint64_t bytes = 0);
    const Range& at(std::uint32_t binding) const; // null buffer when unset

  private:
    std::array<Range, 64> ranges_{};
};

// A list of commands, recorded once and submitted any number of times.
class Commands {
  public:
    explicit Commands(Device& device);
    ~Commands();
    Commands(Commands&&) noexcept;

    // Runs ceil(items / localSize) workgroups, folded into y above 65 535 (globalIndex() in shaders/lib/dispatch.glsl unfolds).
    template <class Push> void dispatch(const Kernel& k, const Bindings& b, std::uint64_t items, const Push& push) {
        dispatchBytes(k, b, items, std::as_bytes(std::span(&push, 1)));
    }
    // Group counts (3 uints) come from `arguments` at `offset`.
    template <class Push>
    void dispatchIndirect(const Kernel& k, const Bindings& b, const Buffer& arguments, std::uint64_t offset, const Push& push) {
        dispatchIndirectBytes(k, b, arguments, offset, std::as_bytes(std::span(&push, 1)));
    }
    void fill(const Buffer& buffer, std::uint32_t value);
    void barrier(); // everything before is visible to everything after; dispatch() does not insert any

    void submitAndWait(); // adds to the device's kernelTimes(); throws Error(Device) when the device is lost

  private:
    friend double dispatchNothing(Device&, const Kernel&, const Bindings&);
    void dispatchBytes(const Kernel&, const Bindings&, std::uint64_t items, std::span<const std::byte> push);
    void dispatchIndirectBytes(const Kernel&, const Bindings&, const Buffer&, std::uint64_t offset, std::span<const std::byte> push);
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// Runs each kernel once over no items, so that just-in-time compilation happens now and is counted in compileSeconds().
// lavapipe compiles for the texel formats bound: give the texel buffers the kernels will read, storage buffers do not matter. It compiles several at
// once where that pays (src/vk/warm_up.cpp).
void warmUp(Device& device, std::span<const Kernel* const> kernels, const Bindings& bindings = {});

} // namespace cmpg
