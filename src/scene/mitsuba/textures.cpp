// Bitmaps and checkerboards of a Mitsuba scene.
#include "scene/mitsuba/load.h"

#include <algorithm>

namespace cmpg {
namespace {

Wrap wrapOf(const std::string& mode) { return mode == "clamp" ? Wrap::Clamp : mode == "mirror" ? Wrap::Mirror : Wrap::Repeat; }

MitsubaTexture readBitmap(MitsubaLoad& load, const MitsubaObject& texture) {
    MitsubaTexture out;
    const std::string file = texture.string("filename", "");
    if (file.empty())
        texture.fail("the bitmap needs a filename");
    const MitsubaElement& at = *texture.find("filename");
    out.image = decodeImage(load.document.read(at, file), load.document.place(at) + ": " + file, load.imageLimits());
    out.address.nearest = texture.oneOf("filter_type", {"bilinear", "nearest", "trilinear", "ewa"}) == "nearest";
    const std::string wrap = texture.oneOf("wrap_mode", {"repeat", "mirror", "clamp"});
    out.address.wrapU = wrapOf(texture.find("wrap_mode_u") ? texture.oneOf("wrap_mode_u", {"repeat", "mirror", "clamp"}) : wrap);
    out.address.wrapV = wrapOf(texture.find("wrap_mode_v") ? texture.oneOf("wrap_mode_v", {"repeat", "mirror", "clamp"}) : wrap);
    out.srgb = !texture.boolean("raw", false) && texture.real("gamma", 2.2) != 1;
    texture.ignore({"format", "accel"});
    return out;
}

// Two by two texels without interpolation are the same function.
MitsubaTexture readCheckerboard(MitsubaLoad& load, const MitsubaObject& texture) {
    const auto color = [&](const char* name, double fallback) {
        const MitsubaElement* e = texture.find(name);
        if (e && load.document.resolve(*e).isObject())
            load.document.fail(*e, "textures within a checkerboard are not supported", "", "give " + std::string(name) + " as <rgb>");
        return e ? mitsubaColor(load.document, load.document.resolve(*e), false) : glm::dvec3(fallback);
    };
    const glm::vec3 colors[] = {color("color0", 0.4), color("color1", 0.2)};
    MitsubaTexture out;
    out.image.width = out.image.height = 2;
    out.image.channels = 3;
    out.image.linear = true;
    for (const int c : {0, 1, 1, 0})
        out.image.values.insert(out.image.values.end(), {colors[c].x, colors[c].y, colors[c].z});
    out.address.nearest = true;
    return out;
}

} // namespace

glm::mat3x2 mitsubaUvTransform(const MitsubaObject& texture) {
    glm::dmat4 m = texture.transform("to_uv").value_or(glm::dmat4(1));
    // Of version 0.6.
    const double u = texture.real("uscale", 1), v = texture.real("vscale", 1), x = texture.real("uoffset", 0), y = texture.real("voffset", 0);
    m = glm::dmat4(glm::dvec4(u, 0, 0, 0), glm::dvec4(0, v, 0, 0), glm::dvec4(0, 0, 1, 0), glm::dvec4(x, y, 0, 1)) * m;
    return {glm::vec2(m[0]), glm::vec2(m[1]), glm::vec2(m[3])};
}

MitsubaTexture readMitsubaTexture(MitsubaLoad& load, const MitsubaObject& texture) {
    if (texture.type() != "bitmap" && texture.type() != "checkerboard")
        texture.fail("the texture " + texture.type() + " is not supported", "", "use bitmap or checkerboard, or bake it into a picture");
    MitsubaTexture out = texture.type() == "bitmap" ? readBitmap(load, texture) : readCheckerboard(load, texture);
    out.address.uvTransform = mitsubaUvTransform(texture);
    load.noteUnread(texture);
    return out;
}

MitsubaTexture scalarTexture(MitsubaTexture texture) {
    const RawImage& from = texture.image;
    if (from.channels <= 2)
        return texture;
    RawImage grey{from.width, from.height, 1, {}, {}, true};
    grey.values.resize(from.pixels());
    for (std::size_t i = 0; i < grey.values.size(); ++i) {
        const auto value = [&](std::uint32_t c) {
            const std::size_t at = i * from.channels + from.channel(c);
            const float code = from.bytes.empty() ? from.values[at] : float(from.bytes[at]) / 255.0f;
            return texture.srgb && !from.linear ? srgbDecode(code) : code;
        };
        grey.values[i] = 0.212671f * value(0) + 0.715160f * value(1) + 0.072169f * value(2);
    }
    texture.image = std::move(grey);
    texture.srgb = false;
    return texture;
}

} // namespace cmpg
