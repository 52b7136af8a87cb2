// inspect: what a scene holds, what can be differentiated, what a run on it would need.
#include "app/commands.h"
#include "base/log.h"
#include "base/utf8.h"
#include "session/library_options.h"
#include "session/session.h"

#include <cmpg/renderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ostream>

namespace cmpg {
namespace {

std::string rangeText(const Parameter& p) {
    char text[48];
    if (std::isinf(p.highest()))
        std::snprintf(text, sizeof text, "[%g,inf)", double(p.lowest()));
    else
        std::snprintf(text, sizeof text, "[%g,%g]", double(p.lowest()), double(p.highest()));
    return text;
}

std::string valueText(const Parameter& p) {
    if (p.entries() != p.channels || p.values.empty())
        return "";
    std::string text = "  =";
    for (const float v : p.values) {
        char number[24];
        std::snprintf(number, sizeof number, "%s%.4g", text == "  =" ? " " : ",", double(v));
        text += number;
    }
    return text;
}

std::size_t charactersOf(const std::string& text) {
    return text.size() - std::size_t(std::ranges::count_if(text, continuesCharacter));
}

void listParameters(std::ostream& out, Report& report, const Scene& scene) {
    std::size_t longest = 0;
    for (const Parameter& p : scene.parameters)
        longest = std::max(longest, charactersOf(p.name));
    auto& list = report.extra["parameters"] = nlohmann::ordered_json::array();
    const std::vector<bool> without = scene.withoutDerivative();
    out << "parameters (linear values; name, size, range):\n";
    for (std::size_t i = 0; i < scene.parameters.size(); ++i) {
        const Parameter& p = scene.parameters[i];
        std::string name = p.name, size = std::to_string(p.width) + "x" + std::to_string(p.height);
        name.append(longest + 2 - charactersOf(name), ' ');
        size.resize(11, ' ');
        out << "  " << name << size << (p.channels == 3 ? "rgb     " : "scalar  ") << rangeText(p) << valueText(p) << (without[i] ? "  no derivative" : "") << '\n';
        list.push_back({{"name", p.name},
                        {"width", p.width},
                        {"height", p.height},
                        {"channels", p.channels},
                        {"textured", p.textured},
                        {"differentiable", !without[i]},
                        {"lowest", p.lowest()},
                        {"highest", std::isinf(p.highest()) ? nlohmann::ordered_json() : nlohmann::ordered_json(p.highest())}});
    }
}

void listContents(std::ostream& out, Report& report, const Scene& scene) {
    out << "cameras:\n";
    auto& cameras = report.extra["cameras"] = nlohmann::ordered_json::array();
    for (const Camera& c : scene.cameras) {
        char line[128];
        if (c.orthographic)
            std::snprintf(line, sizeof line, "orthographic, half height %g", double(c.ymag));
        else
            std::snprintf(line, sizeof line, "perspective, %.4g degrees", double(c.yfov) * 180 / 3.14159265358979);
        out << "  " << (c.name.empty() ? "(unnamed)" : c.name) << "  " << line << '\n';
        cameras.push_back(c.name);
    }
    out << "materials:\n";
    auto& materials = report.extra["materials"] = nlohmann::ordered_json::array();
    for (const Material& m : scene.materials) {
        out << "  " << m.name << (m.hasNormalMap ? "  normal map" : "") << (m.coverage ? "  partial coverage" : m.alphaMask ? "  alpha mask" : "") << '\n';
        materials.push_back(m.name);
    }
    out << "geometry:    " << scene.geometry.triangles.size() << " triangles, " << scene.geometry.positions.size() << " vertices\n";
    out << "lights:      " << scene.lights.size() << " punctual" << (scene.environment ? ", an environment" : "") << '\n';
    out << "depth:       " << scene.maxDepth << " segments\n";
    report.extra["triangles"] = scene.geometry.triangles.size();
    report.extra["lights"] = scene.lights.size();
    report.extra["maxDepth"] = scene.maxDepth;
}

// What a renderer of the scene takes, for passes as the options want them.
v1::Footprint footprintOf(const Options& options, Session& session, bool allFeatures) {
    v1::PathOptions paths = pathOptions(options, options.effectiveDepth(session.scene.maxDepth()));
    paths.allFeatures |= allFeatures;
    v1::Renderer renderer(session.openDevice(), session.scene, {.paths = paths, .parameters = session.parameters});
    const v1::PassOptions pass{.train = options.effectiveTrain()};
    if (session.parameters.empty())
        return renderer.footprint({v1::PassKind::Render}, pass);
    return renderer.footprint({v1::PassKind::Render, v1::PassKind::Forward, v1::PassKind::Backward}, pass);
}

const char* kindName(v1::PassKind kind) { return kind == v1::PassKind::Render ? "image" : kind == v1::PassKind::Forward ? "forward" : "reverse"; }

void listKernels(std::ostream& out, Report& report, const v1::Footprint& scene, const v1::Footprint& all) {
    auto& list = report.extra["kernel_sizes"] = nlohmann::ordered_json::array();
    std::map<std::pair<v1::PassKind, std::string>, std::uint64_t> needed; // bytes, of the kernels for all classes of surfaces
    for (const v1::Footprint::Kernel& k : scene.kernels)
        needed[{k.kind, k.name}] += k.bytes;
    out << "kernels (KiB of SPIR-V):                  scene       all    module\n";
    std::uint64_t sums[3]{};
    for (const v1::Footprint::Kernel& k : all.kernels) {
        const auto found = needed.find({k.kind, k.name});
        const std::uint64_t sizes[] = {found == needed.end() ? 0 : found->second, k.bytes, k.moduleBytes};
        for (int i = 0; i < 3; ++i)
            sums[i] += sizes[i];
        char line[160];
        std::snprintf(line, sizeof line, "  %-8s %-24s %10.1f%10.1f%10.1f\n", kindName(k.kind), k.name.c_str(), double(sizes[0]) / 1024,
                      double(sizes[1]) / 1024, double(sizes[2]) / 1024);
        out << line;
        list.push_back({{"mode", kindName(k.kind)}, {"kernel", k.name}, {"scene", sizes[0]}, {"all_features", sizes[1]}, {"module", sizes[2]}});
    }
    char line[160];
    std::snprintf(line, sizeof line, "  %-33s %10.1f%10.1f%10.1f\n", "sum", double(sums[0]) / 1024, double(sums[1]) / 1024, double(sums[2]) / 1024);
    out << line;
}

void listMemory(std::ostream& out, Report& report, const v1::Footprint& scene, const v1::Footprint& all) {
    std::map<std::string, std::array<std::uint64_t, 2>> rows;
    std::array<std::uint64_t, 2> sum{};
    for (int i = 0; i < 2; ++i)
        for (const auto& [name, bytes] : (i ? all : scene).buffers) {
            rows[name][std::size_t(i)] = bytes;
            sum[std::size_t(i)] += bytes;
        }
    const auto line = [&](const std::string& name, const std::array<std::uint64_t, 2>& bytes) {
        char text[160];
        std::snprintf(text, sizeof text, "  %-33s %10.3f%10.3f\n", name.c_str(), double(bytes[0]) / 1048576, double(bytes[1]) / 1048576);
        out << text;
    };
    out << "device memory (MiB):                      scene       all\n";
    for (const auto& [name, bytes] : rows)
        line(name, bytes);
    line("sum", sum);
    report.extra["buffers"] = scene.buffers;
    report.extra["buffers_all_features"] = all.buffers;
}

// What a run would take, beside what it would take with every feature on. Compiles nothing.
void describeDevice(std::ostream& out, const Options& options, Report& report, Session& session) {
    const v1::Footprint scene = footprintOf(options, session, false), all = footprintOf(options, session, true);
    auto& features = report.extra["features"] = nlohmann::ordered_json::object();
    out << "features:\n";
    for (const auto& [name, value] : scene.features) {
        char line[160];
        std::snprintf(line, sizeof line, "  %-36s %s\n", name.c_str(), value.c_str());
        out << line;
        features[name] = value;
    }
    listKernels(out, report, scene, all);
    listMemory(out, report, scene, all);
    report.addDevice(session.device());
}

} // namespace

ExitStatus runInspect(const Options& options, Report& report) {
    std::ostream& out = textOut(options);
    Session session(options, report);
    listContents(out, report, session.host());
    listParameters(out, report, session.host());
    describeDevice(out, options, report, session);
    return ExitStatus::Done;
}

} // namespace cmpg
