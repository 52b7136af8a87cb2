// --list-devices and --version: neither needs a usable device, --version needs none at all.
#include "app/commands.h"

#include <iostream>

namespace cmpg {

ExitStatus runListDevices(const Options& options, Report& report) {
    const std::vector<DeviceInfo> devices = Device::list();
    auto& list = report.extra["devices"] = nlohmann::ordered_json::array();
    std::ostream& out = textOut(options);
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const DeviceInfo& d = devices[i];
        out << i << "  " << d.name << "  (" << d.type << ", " << d.driver << ")";
        if (!d.usable)
            out << "  not usable: " << d.missing;
        out << '\n';
        list.push_back(
            {{"index", i}, {"name", d.name}, {"type", d.type}, {"driver", d.driver}, {"usable", d.usable}, {"missing", d.missing}});
    }
    return ExitStatus::Done;
}

ExitStatus runVersion(const Options& options, Report& report) {
    std::ostream& out = textOut(options);
    out << "cmpg-vk " << CMPG_VERSION << '\n';
    report.extra["version"] = CMPG_VERSION;
    try {
        for (const DeviceInfo& d : Device::list()) {
            out << "device: " << d.name << " (" << d.type << ", " << d.driver << ")\n";
            if (d.usable)
                out << "  subgroups of " << d.subgroupSize << ", 64-bit atomics: " << (d.int64Atomics ? "yes" : "no")
                    << ", float64: " << (d.float64 ? "yes" : "no") << ", storage buffers up to " << (d.maxStorageBufferRange >> 20)
                    << " MiB, " << (d.variant == KernelVariant::Portable ? "portable" : d.variant == KernelVariant::Cpu ? "CPU" : "full") << " kernels\n";
            else
                out << "  not usable: " << d.missing << '\n';
        }
    } catch (const Error& e) {
        out << "device: none (" << e.what() << ")\n";
    }
    out << "required: Vulkan 1.3, a compute queue, scalarBlockLayout, maintenance4, subgroup ballot and arithmetic in compute, "
        << kStorageBuffersPortable << " storage buffers in a kernel (" << kStorageBuffers << " with all that is optional)\n"
        << "optional: 64-bit integers and their atomics, texel buffers of 2^26 elements\n";
    return ExitStatus::Done;
}

} // namespace cmpg
