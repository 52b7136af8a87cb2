// First dispatches. lavapipe compiles a kernel to machine code then, on the one queue of its device, while other cores wait. What it has compiled goes
// to Mesa's cache on disk, where other devices find it: helpers, each with a device of its own, compile some of the kernels into that cache.
#include "vk/device.h"

#include "base/log.h"
#include "vk/impl.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace cmpg {

Processors::Place::Place(Processors& processors, bool waits) : processors_(processors) {
    const unsigned all = std::max(1u, std::thread::hardware_concurrency());
    std::unique_lock lock(processors_.mutex_);
    if (waits)
        processors_.freed_.wait(lock, [&] { return processors_.taken_ < all; });
    ++processors_.taken_;
}

Processors::Place::~Place() {
    const std::lock_guard lock(processors_.mutex_);
    --processors_.taken_;
    processors_.freed_.notify_all();
}

// Runs a kernel over no items: no workgroup is launched, the driver compiles all the same. Returns the seconds.
double dispatchNothing(Device& device, const Kernel& kernel, const Bindings& bindings) {
    static constexpr std::array<std::byte, 128> kZeros{};
    Commands commands(device);
    const Stopwatch watch;
    commands.dispatchBytes(kernel, bindings, 0, std::span(kZeros).first(kernel.impl()->interface.pushBytes));
    commands.submitAndWait();
    return watch.seconds();
}

namespace {

// Reading code from the cache takes a part of the time that the driver took to read the kernel, compiling it several times that.
bool wasCompiled(double seconds, const Kernel& kernel) { return seconds > 0.01 + 2 * kernel.impl()->createSeconds; }

// Buffers of a helper's device, one of each format, in the places of ours: lavapipe compiles for formats.
class Dummies {
  public:
    explicit Dummies(Device& device) {
        for (const Texel texel : {Texel::None, Texel::Rgba32f, Texel::Rgba32ui, Texel::R32f, Texel::R32ui})
            buffers_.emplace(texel, Buffer(device, "dummy", 16, MemoryKind::Transient, texel));
    }
    Bindings inPlaceOf(const Bindings& bindings, const Kernel& kernel) const {
        Bindings result;
        for (const auto& declared : kernel.impl()->interface.bindings)
            if (const Buffer* buffer = bindings.at(declared.number).buffer; buffer && *buffer)
                result.set(declared.number, buffers_.at(buffer->impl()->texel));
        return result;
    }

  private:
    std::map<Texel, Buffer> buffers_;
};

// First dispatches of kernels on a device, with helpers from the first kernel on that the driver has to compile.
class FirstDispatches {
  public:
    FirstDispatches(Device& device, std::vector<const Kernel*> kernels, const Bindings& bindings)
        : device_(device), bindings_(bindings), left_(std::move(kernels)) {
        std::ranges::stable_sort(left_, {}, [](const Kernel* k) { return k->impl()->spirv.size(); });
    }
    ~FirstDispatches() {
        const std::lock_guard lock(mutex_);
        left_.clear(); // helpers end
    }

    void run() {
        // The small ones tell whether there is anything to compile. Then the largest come first: none of them shall be the last to begin.
        while (const Kernel* const kernel = take(helpers_.empty(), nullptr))
            if (wasCompiled(firstOf(*kernel), *kernel) && helpers_.empty())
                for (std::uint32_t i = 0; i < device_.impl().compileHelpers; ++i)
                    helpers_.emplace_back([this] { help(); });
        helpers_.clear(); // they are done
        double loading = 0;
        for (const Kernel* const kernel : helped_)
            loading += firstOf(*kernel);
        double compiling = 0;
        for (const auto& [name, seconds] : helpersSeconds_) {
            device_.impl().compileTimes[name] += seconds;
            compiling += seconds;
        }
        if (loading > 0.5 * compiling) // devices do not share what they compile
            device_.impl().compileHelpers = 0;
        if (failure_)
            tellFailure();
    }

  private:
    double firstOf(const Kernel& kernel) {
        const double seconds = dispatchNothing(device_, kernel, bindings_);
        device_.impl().compileTimes[kernel.name()] += seconds;
        return seconds;
    }

    // A kernel that nobody has begun; null: none is left.
    const Kernel* take(bool smallest, std::vector<const Kernel*>* taken) {
        const std::lock_guard lock(mutex_);
        if (left_.empty())
            return nullptr;
        const auto chosen = smallest ? left_.begin() : left_.end() - 1;
        const Kernel* const kernel = *chosen;
        left_.erase(chosen);
        if (taken)
            taken->push_back(kernel);
        return kernel;
    }

    void help() {
        try {
            const Kernel* kernel = take(false, &helped_);
            if (!kernel)
                return;
            const Processors::Place place(device_.impl().processors, false);
            Device device(device_.impl().options); // Mesa has written its cache when this is gone
            device.impl().fault.submissions = device_.impl().fault.helpers;
            const Dummies dummies(device);
            for (; kernel; kernel = take(false, &helped_)) {
                const Kernel copy = kernel->copyFor(device);
                const double seconds = dispatchNothing(device, copy, dummies.inPlaceOf(bindings_, copy));
                const std::lock_guard lock(mutex_);
                helpersSeconds_[kernel->name()] += seconds;
            }
        } catch (...) {
            const std::lock_guard lock(mutex_);
            failure_ = std::current_exception();
        }
    }

    // Results do not depend on helpers. Where the validation layers are on, a message of theirs is an error all the same.
    void tellFailure() {
        device_.impl().compileHelpers = 0;
        try {
            std::rethrow_exception(failure_);
        } catch (const std::exception& error) {
            if (device_.impl().instance->log)
                throw;
            const auto* const known = dynamic_cast<const Error*>(&error); // or memory on the host ran out
            logWarn("kernels are compiled one after the other from here on: " + std::string(error.what()) +
                    (known && !known->cause.empty() ? ": " + known->cause : ""));
        }
    }

    Device& device_;
    const Bindings& bindings_;
    std::mutex mutex_; // of what follows
    std::vector<const Kernel*> left_, helped_;
    std::map<std::string, double> helpersSeconds_;
    std::exception_ptr failure_;
    std::vector<std::jthread> helpers_; // last: the others outlive them
};

} // namespace

void warmUp(Device& device, std::span<const Kernel* const> kernels, const Bindings& bindings) {
    const Stopwatch watch;
    Device::Impl& impl = device.impl();
    const Processors::Place place(impl.processors, false);
    const auto times = std::exchange(impl.kernelTimes, {});
    std::vector<const Kernel*> fresh;
    for (const Kernel* kernel : kernels)
        if (std::exchange(kernel->impl()->dispatched, true))
            dispatchNothing(device, *kernel, bindings); // it may be bound to other formats now
        else
            fresh.push_back(kernel);
    FirstDispatches(device, std::move(fresh), bindings).run();
    impl.kernelTimes = times;
    impl.compileSeconds += watch.seconds();
}

} // namespace cmpg
