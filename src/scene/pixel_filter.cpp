// Reconstruction filters as scene files and users describe them.
#include "scene/pixel_filter.h"

#include "base/error.h"

#include <charconv>

namespace cmpg {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorKind::Usage, what, {}, "give box, tent, tent:RADIUS, gaussian or gaussian:DEVIATION, in pixels", {"filter"});
}

void requireWidth(double width, double widest, const std::string& name) {
    if (!(width >= kNarrowestFilter && width <= widest))
        refuse("the " + name + " of the filter must be from 0.01 to " + std::to_string(int(widest)) + " pixels");
}

} // namespace

PixelFilter tentFilter(double radius) { return {PixelFilter::Kind::Tent, float(radius)}; }
PixelFilter gaussianFilter(double deviation) { return {PixelFilter::Kind::Gaussian, float(4 * deviation), float(deviation)}; }

PixelFilter pixelFilter(const v1::ReconstructionFilter& filter) {
    using Kind = v1::ReconstructionFilter::Kind;
    if (filter.kind == Kind::Box) {
        if (filter.width != 0)
            refuse("a box filter has no width: it is the pixel's square");
        return {};
    }
    const bool tent = filter.kind == Kind::Tent;
    if (filter.width == 0)
        return tent ? tentFilter() : gaussianFilter();
    requireWidth(filter.width, tent ? kWidestTent : kWidestGaussian, tent ? "radius" : "deviation");
    return tent ? tentFilter(filter.width) : gaussianFilter(filter.width);
}

std::string nameOf(const PixelFilter& filter) {
    if (filter.kind == PixelFilter::Kind::Box)
        return "box";
    const bool tent = filter.kind == PixelFilter::Kind::Tent;
    char number[32];
    char* const end = std::to_chars(number, number + sizeof number, tent ? filter.radius : filter.deviation).ptr; // the shortest that is this number
    return (tent ? "tent:" : "gaussian:") + std::string(number, end);
}

v1::ReconstructionFilter v1::ReconstructionFilter::parse(const std::string& text) {
    const std::size_t colon = text.find(':');
    const std::string kind = text.substr(0, colon);
    ReconstructionFilter filter;
    if (kind == "tent")
        filter.kind = Kind::Tent;
    else if (kind == "gaussian")
        filter.kind = Kind::Gaussian;
    else if (kind != "box")
        refuse("there is no filter '" + text + "'");
    if (colon != std::string::npos) {
        const char* const end = text.data() + text.size();
        const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, filter.width);
        if (error != std::errc() || rest != end || !(filter.width > 0)) // 0 stands for the default
            refuse("the filter '" + text + "' has no positive number after the colon");
        pixelFilter(filter);
    }
    return filter;
}

} // namespace cmpg
