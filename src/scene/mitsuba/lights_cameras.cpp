// Sensors, lights and the environment of a Mitsuba scene.
#include "scene/mitsuba/load.h"
#include "scene/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtx/component_wise.hpp>

namespace cmpg {
namespace {

constexpr double kLeast = 1e-4; // of angles, from nothing and from half a turn

// The picture: size, and the part of the film that is cropped.
struct Film {
    double width = 768, height = 576; // of all of it
    glm::dvec2 cropSize{768, 576}, cropOffset{0};
    PixelFilter filter = gaussianFilter();
};

// Those without negative weights.
PixelFilter readFilter(MitsubaLoad& load, const MitsubaObject& filter) {
    const std::string& type = filter.type();
    PixelFilter out;
    if (type == "tent")
        out = tentFilter(filter.real("radius", kTentRadius, kNarrowestFilter, kWidestTent));
    else if (type == "gaussian")
        out = gaussianFilter(filter.real("stddev", kGaussianDeviation, kNarrowestFilter, kWidestGaussian));
    else if (type != "box" && !load.options.filter)
        load.warn("pixels are averaged over their square, in place of Mitsuba's " + type.substr(0, 32) + " filter");
    load.noteUnread(filter);
    return out;
}

Film readFilm(MitsubaLoad& load, const MitsubaObject& sensor) {
    constexpr std::int64_t kMostPixels = 1 << 15;
    Film film;
    const std::vector<MitsubaObject> films = sensor.objects("film");
    if (films.size() > 1)
        sensor.fail("the sensor has more than one film");
    if (films.empty())
        return film;
    const MitsubaObject& f = films.front();
    film.width = double(f.integer("width", 768, 1, kMostPixels));
    film.height = double(f.integer("height", 576, 1, kMostPixels));
    film.cropSize.x = double(f.integer("crop_width", std::int64_t(film.width), 1, kMostPixels));
    film.cropSize.y = double(f.integer("crop_height", std::int64_t(film.height), 1, kMostPixels));
    film.cropOffset.x = double(f.integer("crop_offset_x", 0, 0, kMostPixels));
    film.cropOffset.y = double(f.integer("crop_offset_y", 0, 0, kMostPixels));
    if (film.cropOffset.x + film.cropSize.x > film.width || film.cropOffset.y + film.cropSize.y > film.height)
        f.fail("the crop reaches beyond the film");
    const std::vector<MitsubaObject> filters = f.objects("rfilter");
    if (!filters.empty())
        film.filter = readFilter(load, filters.front());
    f.ignore({"file_format", "pixel_format", "component_format", "sample_border", "banner", "gamma", "exposure", "high_quality_edges", "compensate",
              "fill", "attach_log", "label", "tonemap_method", "key", "burn"});
    load.noteUnread(f);
    return film;
}

double focalLength(const MitsubaObject& sensor) { // in millimetres
    const MitsubaElement* e = sensor.find("focal_length");
    if (!e)
        return 50;
    std::string text = sensor.string("focal_length", "");
    if (text.ends_with("mm"))
        text.resize(text.size() - 2);
    const double length = mitsubaNumbers(sensor.document(), *e, text, 1, 1)[0];
    if (!(length > 0))
        sensor.fail("the focal length is not positive");
    return length;
}

// Half the height of the film at distance 1.
double halfHeight(const MitsubaObject& sensor, double aspect) {
    std::string axis = sensor.oneOf("fov_axis", {"x", "y", "diagonal", "smaller", "larger"});
    double half = 0;
    if (sensor.find("fov")) {
        half = std::tan(glm::radians(sensor.real("fov", 50, 0, 180)) / 2);
    } else {
        constexpr double kDiagonal = 43.266615305567875; // of film of 36 mm by 24 mm
        half = kDiagonal / (2 * focalLength(sensor));
        axis = "diagonal";
    }
    if (!(half > kLeast && half < 1 / kLeast))
        sensor.fail("the field of view has no size, or is all of a half turn");
    if (axis == "smaller")
        axis = aspect > 1 ? "y" : "x";
    if (axis == "larger")
        axis = aspect > 1 ? "x" : "y";
    if (axis == "diagonal")
        return half / std::sqrt(1 + aspect * aspect);
    return axis == "x" ? half / aspect : half;
}

// Mitsuba does not see what is nearer or farther than these planes.
void warnOfClipping(MitsubaLoad& load, const MitsubaObject& sensor, const Camera& camera) {
    const double nearest = sensor.find("near_clip") ? sensor.real("near_clip", 0) : 0;
    const double farthest = sensor.find("far_clip") ? sensor.real("far_clip", 0) : std::numeric_limits<double>::infinity();
    const glm::dvec3 along(-camera.toWorld[2]), eye(camera.toWorld[3]);
    const auto isCut = [&](const glm::vec3& position) {
        const double depth = glm::dot(glm::dvec3(position) - eye, along);
        return depth > 0 && (depth < nearest || depth > farthest);
    };
    if (std::any_of(load.scene.geometry.positions.begin(), load.scene.geometry.positions.end(), isCut))
        load.warn(camera.name + ": near_clip and far_clip are left out, and so what they cut away is seen; remove these shapes to see past them");
}

void addSensor(MitsubaLoad& load, const MitsubaObject& sensor) {
    const bool perspective = sensor.type() == "perspective" || sensor.type() == "thinlens";
    if (!perspective && sensor.type() != "orthographic")
        sensor.fail("the sensor " + sensor.type().substr(0, 64) + " is not supported", "", "use perspective or orthographic");
    const Film film = readFilm(load, sensor);
    Camera camera;
    camera.name = uniqueName(sensor.id().empty() ? "camera" + std::to_string(load.scene.cameras.size()) : sensor.id(), load.cameraNames);
    const glm::dmat4 toWorld = load.toScene * sensor.transform("to_world").value_or(glm::dmat4(1));
    // Mitsuba's cameras look along +z with x to the left.
    const glm::dmat4 turned = toWorld * glm::dmat4(glm::dvec4(-1, 0, 0, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 0, 0, 1));
    const std::optional<glm::mat4> frame = load.cameraFrame(turned);
    if (!frame)
        sensor.fail("the sensor's transform is singular", "a scale of zero", "check its to_world");
    camera.toWorld = *frame;
    const double aspect = film.width / film.height;
    const glm::dvec2 share(film.cropSize.x / film.width, film.cropSize.y / film.height);
    double half = 0;
    if (perspective) {
        half = halfHeight(sensor, aspect) * share.y;
        camera.yfov = float(2 * std::atan(half));
    } else {
        const double width = glm::length(glm::dvec3(toWorld[0])), height = glm::length(glm::dvec3(toWorld[1]));
        if (std::abs(height / width - 1) > kLeast)
            load.warn(camera.name + ": an orthographic sensor is scaled by its x alone, since pixels are square here; its transform scales y otherwise");
        half = width / aspect * share.y;
        camera.orthographic = true;
        camera.ymag = float(half);
        if (!(camera.ymag > std::numeric_limits<float>::min()))
            sensor.fail("the sensor sees an area of no size");
    }
    camera.size = glm::uvec2(film.cropSize);
    camera.filter = film.filter;
    camera.aspect = float(film.cropSize.x / film.cropSize.y);
    // The middle of the crop, from that of the film; rows go down.
    const glm::dvec2 middle = film.cropOffset + 0.5 * film.cropSize - 0.5 * glm::dvec2(film.width, film.height);
    camera.center = glm::vec2(glm::dvec2(middle.x, -middle.y) / (0.5 * film.cropSize.y));
    for (const char* offset : {"principal_point_offset_x", "principal_point_offset_y"})
        if (sensor.real(offset, 0) != 0)
            load.document.fail(*sensor.find(offset), "principal point offsets are not supported", "", "crop a larger film instead");
    if (sensor.type() == "thinlens")
        load.warn(camera.name + ": thinlens is rendered without its lens, everything in focus");
    warnOfClipping(load, sensor, camera);
    sensor.ignore({"near_clip", "far_clip", "focus_distance", "aperture_radius", "shutter_open", "shutter_close"});
    sensor.objects("sampler");
    load.noteUnread(sensor);
    load.scene.cameras.push_back(std::move(camera));
}

std::vector<MitsubaObject> sceneObjects(const MitsubaLoad& load, const char* tag) {
    std::vector<MitsubaObject> found;
    for (const MitsubaElement* e : load.document.contents())
        if (load.document.resolve(*e).tag == tag)
            found.emplace_back(load.document, *e);
    return found;
}

glm::vec3 brightness(MitsubaLoad& load, const MitsubaObject& emitter, const char* property) {
    const MitsubaElement* e = emitter.find(property);
    if (!e)
        return glm::vec3(1);
    const MitsubaElement& target = load.document.resolve(*e);
    if (target.isObject())
        load.document.fail(*e, "a texture as " + std::string(property) + " is not supported", "", "give it as <rgb>");
    const glm::dvec3 color = mitsubaColor(load.document, target, true);
    if (!(glm::compMin(color) >= 0))
        load.document.fail(*e, std::string(property) + " is negative");
    return glm::vec3(color);
}

bool isEnvironment(const MitsubaObject& emitter) { return emitter.type() == "envmap" || emitter.type() == "constant"; }

} // namespace

void loadMitsubaSensors(MitsubaLoad& load) {
    for (const MitsubaObject& sensor : sceneObjects(load, "sensor"))
        addSensor(load, sensor);
}

void loadMitsubaLights(MitsubaLoad& load) {
    for (const MitsubaObject& emitter : sceneObjects(load, "emitter")) {
        if (isEnvironment(emitter))
            continue;
        PunctualLight light;
        const glm::dmat4 toWorld = load.toScene * emitter.transform("to_world").value_or(glm::dmat4(1));
        glm::dvec3 position(toWorld[3]), direction(toWorld[2]);
        if (emitter.type() == "point") {
            light.kind = PunctualLight::Kind::Point;
            if (const auto at = emitter.point("position"))
                position = glm::dvec3(load.toScene * glm::dvec4(*at, 1));
            light.intensity = brightness(load, emitter, "intensity");
        } else if (emitter.type() == "spot") {
            light.kind = PunctualLight::Kind::Spot;
            for (const MitsubaObject& texture : emitter.objects("texture"))
                texture.fail("a texture of a spot is not supported", "its light would be brighter without the picture", "leave it out, and lower the intensity");
            const double cutoff = emitter.real("cutoff_angle", 20, 0.01, 90), beam = emitter.real("beam_width", cutoff * 0.75, 0, cutoff);
            light.innerCos = float(std::cos(glm::radians(beam)));
            light.outerCos = float(std::cos(glm::radians(cutoff)));
            light.byAngle = true;
            light.intensity = brightness(load, emitter, "intensity");
        } else if (emitter.type() == "directional") {
            light.kind = PunctualLight::Kind::Directional;
            if (const auto along = emitter.point("direction"))
                direction = glm::dvec3(load.toScene * glm::dvec4(*along, 0));
            light.intensity = brightness(load, emitter, "irradiance");
        } else {
            emitter.fail("the emitter " + emitter.type().substr(0, 64) + " is not supported", "",
                         emitter.type() == "area" ? "put it into a shape" : "use area, point, spot, directional, constant or envmap");
        }
        emitter.ignore({"sampling_weight"});
        load.noteUnread(emitter);
        light.position = glm::vec3(position - load.scene.center);
        if (light.kind != PunctualLight::Kind::Point) {
            if (!(glm::length(direction) > 0))
                emitter.fail("the light has no direction");
            light.direction = glm::vec3(glm::normalize(direction));
        }
        load.scene.lights.push_back(light);
    }
}

void orientMitsubaScene(MitsubaLoad& load) {
    if (!load.options.environment.file.empty())
        return;
    for (const MitsubaObject& emitter : sceneObjects(load, "emitter")) {
        if (emitter.type() != "envmap")
            continue;
        const glm::dmat3 m(emitter.transform("to_world").value_or(glm::dmat4(1)));
        const double scale = std::cbrt(std::abs(glm::determinant(m)));
        const glm::dmat3 rotation = m / scale, unit = glm::transpose(rotation) * rotation;
        constexpr double kRounding = 1e-4;
        for (int i = 0; i < 9; ++i)
            if (!(std::abs(unit[i / 3][i % 3] - (i % 4 == 0)) < kRounding))
                emitter.fail("the environment's transform is more than a rotation", "it shears or squashes", "rotate it only");
        if (glm::determinant(m) < 0)
            emitter.fail("the environment is mirrored", "its transform has a negative determinant", "mirror the picture instead");
        if (std::abs(rotation[1].y - 1) < 1e-9)
            return; // about +y alone
        load.toScene = glm::dmat4(glm::transpose(rotation));
        load.warn("the scene is turned so that its environment stands upright: positions are in the environment's own frame");
        return;
    }
}

void loadMitsubaEnvironment(MitsubaLoad& load) {
    for (const MitsubaObject& emitter : sceneObjects(load, "emitter")) {
        if (!isEnvironment(emitter))
            continue;
        if (load.scene.environment)
            emitter.fail("the scene has two environments", "", "leave one out");
        RawImage image;
        float scale = 1, rotation = 0;
        const bool constant = emitter.type() == "constant";
        if (constant) {
            const glm::vec3 radiance = brightness(load, emitter, "radiance");
            image = {1, 1, 3, {}, {radiance.x, radiance.y, radiance.z}, true};
        } else {
            const std::string file = emitter.string("filename", "");
            if (file.empty())
                emitter.fail("the environment needs a filename");
            const MitsubaElement& at = *emitter.find("filename");
            image = decodeImage(load.document.read(at, file), load.document.place(at) + ": " + file, load.imageLimits());
            scale = float(emitter.real("scale", 1, 0));
            const glm::dmat3 m(load.toScene * emitter.transform("to_world").value_or(glm::dmat4(1)));
            rotation = float(std::atan2(m[2].x, m[2].z));
        }
        emitter.ignore({"sampling_weight", "mis_compensation", "to_world"});
        load.noteUnread(emitter);
        if (!load.setEnvironment(image, scale, rotation))
            emitter.fail("the picture overflows by its scale");
        const std::string name = emitter.id().empty() ? "" : emitter.id() + (constant ? ".radiance" : ".data");
        if (!name.empty()) {
            load.scene.aliases[name] = load.scene.environment->parameter;
            load.scene.aliases[name + ".value"] = load.scene.environment->parameter;
        }
    }
}

} // namespace cmpg
