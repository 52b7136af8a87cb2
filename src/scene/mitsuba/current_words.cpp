// What only versions before 3 have, as Mitsuba 3 says it, or left out.
#include "scene/mitsuba/current_words.h"

#include "base/log.h"
#include "scene/mitsuba/load.h"

#include <algorithm>
#include <cctype>

namespace cmpg {
namespace {

using Names = std::initializer_list<const char*>;

bool isOneOf(const std::string& name, Names names) {
    return std::any_of(names.begin(), names.end(), [&](const char* known) { return name == known; });
}

void drop(MitsubaElement& element, Names names) {
    std::erase_if(element.children, [&](const MitsubaElement* child) { return isOneOf(child->name, names); });
}

const MitsubaElement* childOf(const MitsubaElement& element, const char* name) {
    const auto found = std::find_if(element.children.begin(), element.children.end(), [&](const MitsubaElement* child) { return child->name == name; });
    return found == element.children.end() ? nullptr : *found;
}

// The value of a child, if it has one.
std::string valueOf(const MitsubaElement& element, const char* name, const std::string& fallback = {}) {
    const MitsubaElement* child = childOf(element, name);
    const std::string* value = child ? child->attribute("value") : nullptr;
    return value ? *value : fallback;
}

void dropUnless(MitsubaElement& element, const char* name, Names values) {
    std::string value = valueOf(element, name);
    std::transform(value.begin(), value.end(), value.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (!isOneOf(value, values))
        drop(element, {name});
}

} // namespace

void CurrentWords::add(MitsubaElement& element, const char* tag, const char* name, const std::string& value) {
    MitsubaElement& made = made_.emplace_back();
    made.tag = tag;
    made.name = name;
    made.attributes["value"] = value;
    made.file = element.file;
    made.line = element.line;
    element.children.push_back(&made);
}

void CurrentWords::bitmap(MitsubaElement& element) {
    if (isOneOf(valueOf(element, "filter_type"), {"trilinear", "ewa"})) { // there are no mip maps
        drop(element, {"filter_type"});
        add(element, "string", "filter_type", "bilinear");
    }
    if (childOf(element, "gamma")) {
        const MitsubaObject texture(document_, element);
        const bool raw = texture.real("gamma", 2.2) == 1 || texture.boolean("raw", false);
        drop(element, {"gamma", "raw"});
        add(element, "boolean", "raw", raw ? "true" : "false");
    }
    if (childOf(element, "wrap_mode_u") || childOf(element, "wrap_mode_v")) {
        const std::string both = valueOf(element, "wrap_mode", "repeat"), u = valueOf(element, "wrap_mode_u", both), v = valueOf(element, "wrap_mode_v", both);
        drop(element, {"wrap_mode", "wrap_mode_u", "wrap_mode_v"});
        add(element, "string", "wrap_mode", u);
        if (u != v) {
            add(element, "string", "wrap_mode_v", v);
            logWarn(document_.place(element) + ": along u the texture wraps as " + u.substr(0, 16) + ", along v as " + v.substr(0, 16) +
                    ", for which Mitsuba 3 has no word: it refuses the written scene until wrap_mode_v is taken out");
        }
    }
    drop(element, {"cache", "max_anisotropy", "channel"});
}

void CurrentWords::film(MitsubaElement& element) {
    if (isOneOf(element.type, {"ldrfilm", "mfilm", "tiledhdrfilm"}))
        element.type = "hdrfilm";
    drop(element, {"gamma", "exposure", "high_quality_edges", "fill", "attach_log", "tonemap_method", "key", "burn", "digits", "variable"});
    std::erase_if(element.children, [](const MitsubaElement* child) { return child->name.starts_with("label") || child->name.starts_with("metadata"); });
    dropUnless(element, "file_format", {"openexr", "rgbe", "pfm"});
    dropUnless(element, "pixel_format", {"luminance", "luminance_alpha", "rgb", "rgba", "xyz", "xyza"});
}

// By its index in relation to what surrounds it, since Mitsuba 3 has metals in a vacuum alone.
void CurrentWords::conductor(MitsubaElement& element) {
    const bool index = childOf(element, "eta") || childOf(element, "k");
    if (!childOf(element, "ext_eta") && !(index && childOf(element, "material")))
        return;
    const ConductorIndex relative = conductorIndex(MitsubaObject(document_, element));
    drop(element, {"ext_eta", "material", "eta", "k"});
    for (const auto& [name, value] : {std::pair("eta", relative.eta), std::pair("k", relative.k)}) {
        char text[96];
        std::snprintf(text, sizeof text, "%.9g, %.9g, %.9g", double(value.x), double(value.y), double(value.z));
        add(element, "rgb", name, text);
    }
}

MitsubaElement CurrentWords::of(const MitsubaElement& old) {
    MitsubaElement element = old;
    const std::string &tag = element.tag, &type = element.type;
    if (tag == "texture" && type == "bitmap") {
        bitmap(element);
    } else if (tag == "film") {
        film(element);
    } else if (tag == "bsdf" && (type == "conductor" || type == "roughconductor")) {
        conductor(element);
    } else if (tag == "bsdf") {
        drop(element, {"specular_sampling_weight"});
    } else if (tag == "emitter" && type == "envmap") {
        drop(element, {"gamma", "cache"});
    } else if (tag == "shape") {
        drop(element, {"collapse", "max_smooth_angle"});
        if (type != "obj" && type != "ply")
            drop(element, {"flip_tex_coords"});
    } else if (tag == "sensor") {
        drop(element, {"kc"});
        if (type != "thinlens")
            drop(element, {"aperture_radius"});
    } else if (tag == "sampler") {
        if (isOneOf(type, {"halton", "hammersley", "sobol"}))
            element.type = "independent";
        drop(element, {"dimension", "scramble"});
    } else if (tag == "integrator") {
        drop(element, {"strict_normals"});
        if (isOneOf(type, {"volpath_simple", "bdpt", "mlt", "pssmlt", "erpt", "photonmapper", "ppm", "sppm", "vpl"})) { // rendered as paths here
            element.type = "path";
            std::erase_if(element.children, [](const MitsubaElement* child) { return !isOneOf(child->name, {"max_depth", "rr_depth", "hide_emitters"}); });
        }
    }
    return element;
}

} // namespace cmpg
