// Indices of refraction by name.
#include "scene/mitsuba/load.h"

#include <cctype>

namespace cmpg {
namespace {

struct Conductor {
    const char* name;
    ConductorIndex index;
};
// Of measured spectra, as Mitsuba 3.9.1 reduces them to RGB.
constexpr Conductor kConductors[] = {
    {"none", {{0, 0, 0}, {1, 1, 1}}},
    {"Ag", {{0.15527619f, 0.11672796f, 0.13838764f}, {4.8283544f, 3.1222224f, 2.1469011f}}},
    {"Al", {{1.6575009f, 0.88040471f, 0.52124447f}, {9.2238111f, 6.2695022f, 4.8370047f}}},
    {"Au", {{0.14303598f, 0.37530708f, 1.4420453f}, {3.9829969f, 2.3855564f, 1.6033592f}}},
    {"Cr", {{4.3696675f, 2.9165053f, 1.6549046f}, {5.2065468f, 4.2313061f, 3.7546988f}}},
    {"Cu", {{0.20100547f, 0.92374951f, 1.1022154f}, {3.9132621f, 2.4530451f, 2.1420898f}}},
    {"Hg", {{2.3989387f, 1.440028f, 0.9095704f}, {6.3275871f, 4.3719249f, 3.4217637f}}},
    {"W", {{4.3708167f, 3.3002465f, 2.9984074f}, {3.5006406f, 2.6048739f, 2.2732332f}}},
};

struct Dielectric {
    const char* name;
    double index;
};
constexpr Dielectric kDielectrics[] = {
    {"vacuum", 1.0},     {"helium", 1.000036},   {"hydrogen", 1.000132}, {"air", 1.000277},        {"carbon dioxide", 1.00045}, {"water", 1.3330},
    {"acetone", 1.36},   {"ethanol", 1.361},     {"glycerol", 1.4729},   {"benzene", 1.501},       {"silicone oil", 1.52045},   {"bromine", 1.661},
    {"water ice", 1.31}, {"fused quartz", 1.458}, {"pyrex", 1.470},      {"acrylic glass", 1.49},  {"polypropylene", 1.49},     {"bk7", 1.5046},
    {"sodium chloride", 1.544}, {"amber", 1.55}, {"pet", 1.5750},        {"diamond", 2.419},       {"carbon tetrachloride", 1.461},
};

bool alike(const std::string& a, const char* b) {
    std::size_t i = 0;
    for (; i < a.size() && b[i]; ++i)
        if (std::tolower(static_cast<unsigned char>(a[i])) != std::tolower(static_cast<unsigned char>(b[i])))
            return false;
    return i == a.size() && !b[i];
}

} // namespace

std::optional<ConductorIndex> conductorIndex(const std::string& name) {
    for (const Conductor& c : kConductors)
        if (alike(name, c.name))
            return c.index;
    return {};
}

std::string conductorNames() {
    std::string list;
    for (const Conductor& c : kConductors)
        list += (list.empty() ? "" : ", ") + std::string(c.name);
    return list;
}

std::optional<double> dielectricIndex(const std::string& name) {
    for (const Dielectric& d : kDielectrics)
        if (alike(name, d.name))
            return d.index;
    return {};
}

} // namespace cmpg
