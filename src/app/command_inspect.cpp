// inspect: what a scene holds, what can be differentiated, what a run on it would need.
#include "app/commands.h"
#include "app/session.h"
#include "base/log.h"

#include <cmath>
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

void listParameters(std::ostream& out, Report& report, const Scene& scene) {
    std::size_t longest = 0;
    for (const Parameter& p : scene.parameters)
        longest = std::max(longest, p.name.size());
    auto& list = report.extra["parameters"] = nlohmann::ordered_json::array();
    out << "parameters (linear values; name, size, range):\n";
    for (const Parameter& p : scene.parameters) {
        std::string name = p.name, size = std::to_string(p.width) + "x" + std::to_string(p.height);
        name.resize(longest + 2, ' ');
        size.resize(11, ' ');
        out << "  " << name << size << (p.channels == 3 ? "rgb     " : "scalar  ") << rangeText(p) << valueText(p) << '\n';
        list.push_back({{"name", p.name},
                        {"width", p.width},
                        {"height", p.height},
                        {"channels", p.channels},
                        {"textured", p.textured},
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
        out << "  " << m.name << (m.hasNormalMap ? "  normal map" : "") << (m.alphaMask ? "  alpha mask" : "") << '\n';
        materials.push_back(m.name);
    }
    out << "geometry:    " << scene.geometry.triangles.size() << " triangles, " << scene.geometry.positions.size() << " vertices\n";
    out << "lights:      " << scene.lights.size() << " punctual" << (scene.environment ? ", an environment" : "") << '\n';
    out << "depth:       " << scene.maxDepth << " segments\n";
    report.extra["triangles"] = scene.geometry.triangles.size();
    report.extra["lights"] = scene.lights.size();
    report.extra["maxDepth"] = scene.maxDepth;
}

// Builds the renderer as a rendering would, with every parameter that --param selects differentiable.
void describeDevice(std::ostream& out, const Options& options, Report& report, Session& session) {
    const View view = viewOf(options, session.scene, "");
    if (session.parameters.empty())
        session.prepare(view, {}, {Renderer::Mode::Render});
    else
        session.prepare(view, {}, {Renderer::Mode::Render, Renderer::Mode::Forward, Renderer::Mode::Reverse});
    auto& features = report.extra["features"] = nlohmann::ordered_json::array();
    out << "features:\n";
    for (const std::string& line : session.renderer().describeFeatures()) {
        out << "  " << line << '\n';
        features.push_back(line);
    }
    session.finish();
    auto& buffers = report.extra["buffers"] = nlohmann::ordered_json::object();
    out << "device memory:\n";
    for (const auto& [name, bytes] : session.deviceMemory().buffers) {
        char line[160];
        std::snprintf(line, sizeof line, "  %10.3f MiB  %s\n", double(bytes) / 1048576, name.c_str());
        out << line;
        buffers[name] = bytes;
    }
}

} // namespace

ExitCode runInspect(const Options& options, Report& report) {
    std::ostream& out = textOut(options);
    Session session(options, report);
    listContents(out, report, session.scene);
    listParameters(out, report, session.scene);
    describeDevice(out, options, report, session);
    return ExitCode::Done;
}

} // namespace cmpg
