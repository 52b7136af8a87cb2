// Parameters: their names, ranges, packed form, and how names and globs find them.
#include "base/error.h"
#include "base/nearest_names.h"
#include "scene/image_decode.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cmpg {
namespace {

constexpr float kUnbounded = std::numeric_limits<float>::infinity();
struct Slot {
    std::uint32_t number;
    const char* name;
    std::uint32_t channels;
    float highest;
};
constexpr Slot kSlots[] = {
#define SLOT(number, Name, name, channels, highest, adam, sgd) {number, #name, channels, highest},
#include "shared/slots.def"
};
constexpr bool slotsAreInOrder() {
    for (std::uint32_t k = 0; k < std::size(kSlots); ++k)
        if (kSlots[k].number != k)
            return false;
    return true;
}
static_assert(std::size(kSlots) == kSlotKinds && slotsAreInOrder());

// The three names most like `name`, for a message.
template <class Things> std::string namesLike(const Things& things, const std::string& name) {
    std::vector<std::string> names;
    names.reserve(things.size());
    for (const auto& thing : things)
        names.push_back(thing.name);
    std::string text;
    for (const std::string& near : nearestNames(std::move(names), name, 3))
        text += (text.empty() ? "" : ", ") + near;
    return text.empty() ? "(there are none)" : text;
}

// * any characters, ? one. After a mismatch only the last * may take one character more, so the time is at most the product of lengths.
bool matches(const std::string& glob, const std::string& text) {
    std::size_t g = 0, t = 0, star = std::string::npos, resume = 0;
    while (t < text.size()) {
        if (g < glob.size() && glob[g] == '*') {
            star = g++;
            resume = t;
        } else if (g < glob.size() && (glob[g] == '?' || glob[g] == text[t])) {
            ++g;
            ++t;
        } else if (star != std::string::npos) {
            g = star + 1;
            t = ++resume;
        } else {
            return false;
        }
    }
    return glob.find_first_not_of('*', g) == std::string::npos;
}

} // namespace

const char* slotName(SlotKind kind) { return kSlots[std::size_t(kind)].name; }
std::uint32_t slotChannels(SlotKind kind) { return kSlots[std::size_t(kind)].channels; }

std::string slotNames() {
    std::string text;
    for (const Slot& slot : kSlots)
        text += (&slot == kSlots ? "" : &slot == std::end(kSlots) - 1 ? " and " : ", ") + std::string(slot.name);
    return text;
}

void Parameter::materialise() {
    if (bytes.empty()) return;
    values.resize(entries());
    for (std::size_t i = 0; i < values.size(); ++i) {
        const int c = int(i % channels);
        values[i] = (srgb ? srgbTable()[bytes[i]] : float(bytes[i]) / 255.0f) * scale[c] + bias[c];
    }
    bytes = {};
    srgb = false;
    scale = glm::vec3(1);
    bias = glm::vec3(0);
}

float Parameter::lowest() const { return kind == SlotKind::Normal ? -highest() : 0.0f; }

float Parameter::highest() const { return kSlots[std::size_t(kind)].highest; }

std::uint32_t Scene::parameter(const std::string& name) const {
    for (std::size_t i = 0; i < parameters.size(); ++i)
        if (parameters[i].name == name) return std::uint32_t(i);
    if (const auto alias = aliases.find(name); alias != aliases.end())
        return alias->second;
    throw Error(ErrorKind::Usage, source + " has no parameter " + name, "the nearest names are " + namesLike(parameters, name),
                "the list of the scene's parameters has them all", {"inspect"});
}

std::vector<std::uint32_t> Scene::select(const std::string& glob) const {
    // A name that is one is meant literally, whatever characters it has.
    for (std::size_t i = 0; i < parameters.size(); ++i)
        if (parameters[i].name == glob) return {std::uint32_t(i)};
    if (const auto alias = aliases.find(glob); alias != aliases.end()) return {alias->second};
    std::vector<std::uint32_t> found;
    for (std::size_t i = 0; i < parameters.size(); ++i)
        if (matches(glob, parameters[i].name)) found.push_back(std::uint32_t(i));
    if (!found.empty()) return found;
    if (glob.find_first_of("*?") == std::string::npos) parameter(glob); // throws
    throw Error(ErrorKind::Usage, source + " has no parameter that matches " + glob,
                "names are case sensitive; the nearest are " + namesLike(parameters, glob), "the list of the scene's parameters has them all", {"inspect"});
}

std::vector<bool> Scene::withoutDerivative() const {
    std::vector<bool> without(parameters.size(), false);
    for (const bool read : {false, true}) // materials may share a parameter: one that reads it decides
        for (const Material& m : materials)
            for (const SlotKind kind : {SlotKind::Metallic, SlotKind::Specular, SlotKind::Roughness})
                if (readsSlot(m, kind) == read) without[m.parameters[std::size_t(kind)]] = !read;
    for (const Material& m : materials)
        if (!hasNormalDerivative(m)) without[m.parameters[std::size_t(SlotKind::Normal)]] = true;
    return without;
}

std::vector<std::uint32_t> Scene::selectDifferentiable(std::span<const std::string> globs, std::vector<std::string>* left) const {
    const std::vector<bool> without = withoutDerivative();
    std::vector<std::uint32_t> selected;
    for (const std::string& glob : globs) {
        const std::vector<std::uint32_t> found = select(glob);
        const bool leaveOut = std::any_of(found.begin(), found.end(), [&](std::uint32_t p) { return !without[p]; }); // else nothing is left
        for (const std::uint32_t p : found) {
            if (leaveOut && without[p]) {
                if (left) left->push_back(parameters[p].name);
            } else if (std::find(selected.begin(), selected.end(), p) == selected.end()) {
                selected.push_back(p);
            }
        }
    }
    return selected;
}

const Camera& Scene::camera(const std::string& name) const {
    if (name.empty()) return cameras.front();
    for (const Camera& camera : cameras)
        if (camera.name == name) return camera;
    throw Error(ErrorKind::Usage, source + " has no camera " + name, "the nearest names are " + namesLike(cameras, name),
                "the list of the scene's cameras has them all", {"inspect"});
}

float Scene::floorOf(std::uint32_t parameter) const {
    constexpr float kMinAlpha = 1e-3f, kMinSheenRoughness = 0.07f; // as in shaders/lib/microfacet.glsl and shaders/lib/lobes/sheen.glsl
    const SlotKind kind = parameters[parameter].kind;
    if (!shapesLobe(kind)) // nor is the environment's radiance a slot of materials
        return 0;
    float floor = 0;
    for (const Material& m : materials) {
        if (m.parameters[std::size_t(kind)] != parameter)
            continue;
        const bool squared = m.model == SurfaceModel::MetallicRoughness || !m.roughnessIsAlpha;
        if (kind == SlotKind::SheenRoughness)
            floor = std::max(floor, kMinSheenRoughness);
        else if (kind == SlotKind::ClearcoatRoughness || (kind == SlotKind::Roughness && squared))
            floor = std::max(floor, std::sqrt(kMinAlpha));
        else if (kind == SlotKind::Roughness || (kind == SlotKind::Anisotropy && !squared))
            floor = std::max(floor, kMinAlpha);
    }
    return floor;
}

} // namespace cmpg
