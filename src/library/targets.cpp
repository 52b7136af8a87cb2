// Targets of the library's surface, and the loss of an image against one.
#include "library/targets.h"

#include "base/error.h"
#include "optimize/loaded_target.h"
#include "optimize/losses.h"
#include "scene/resample.h"

#include <algorithm>
#include <cmath>

namespace cmpg::v1 {

Target Target::load(const std::filesystem::path& file, const std::string& camera, const std::filesystem::path& mask, float exposure) {
    cmpg::Target read = loadTarget(file, {.mask = mask, .exposure = exposure});
    return {camera, std::move(read.image), std::move(read.mask), std::move(read.clipped), std::move(read.name)};
}

Target Target::stream(const std::filesystem::path& file, const std::string& camera, const std::filesystem::path& mask, float exposure) {
    Target target = load(file, camera, mask, exposure);
    target.image.values = std::vector<float>();
    target.mask = std::vector<float>();
    target.clipped = std::vector<std::uint8_t>();
    target.read = [=] { return load(file, camera, mask, exposure); };
    return target;
}

namespace {

// Of an averaged target; Error(Input) where there is none.
glm::uvec2 averagedSize(const Target& target, int width, int height) {
    const Image& image = target.image;
    const auto along = [](int edge, int other, int wanted) { return std::max(1, int(std::lround(double(edge) / other * wanted))); };
    const int w = width > 0 ? width : along(image.width, image.height, height), h = height > 0 ? height : along(image.height, image.width, width);
    const auto text = [](int x, int y) { return std::to_string(x) + "x" + std::to_string(y); };
    const std::string sizes = "target " + target.name + (target.name.empty() ? "is " : " is ") + text(image.width, image.height) + ", not " + text(w, h);
    if (w > image.width || h > image.height)
        throw Error(ErrorKind::Input, sizes, "it has fewer pixels than the size that is asked for", "ask for its own size, or a smaller one", {"width", "height"});
    if (std::abs(along(image.height, image.width, w) - h) > 1)
        throw Error(ErrorKind::Input, sizes, "the size that is asked for has another shape", "give one of the two, or crop the target", {"width", "height"});
    return {w, h};
}

} // namespace

Target Target::averaged(int width, int height) const {
    if (width < 0 || height < 0 || (width == 0 && height == 0))
        throw Error(ErrorKind::Usage, std::to_string(width) + "x" + std::to_string(height) + " is no size of an image", "", "give a width, a height or both", {"width", "height"});
    const bool streams = image.values.empty() && read;
    cmpg::Target weighted = streams ? cmpg::Target() : targetOf(*this, 0); // throws where it is no image
    const glm::uvec2 size(image.width, image.height), fewer = averagedSize(*this, width, height);
    if (size == fewer)
        return *this;
    Target result{.camera = camera, .name = name, .from = from};
    result.image.width = int(fewer.x);
    result.image.height = int(fewer.y);
    if (streams) {
        result.read = [whole = read, fewer] { return whole().averaged(int(fewer.x), int(fewer.y)); };
        return result;
    }
    weighted.mask.resize(image.pixels(), weighted.mask.empty() ? 1.f : 0.f);
    std::vector<float> flags(weighted.clipped.size());
    for (std::size_t i = 0; i < weighted.image.values.size(); ++i) {
        const float weight = weighted.mask[i / 3];
        weighted.image.values[i] = weight > 0 ? weight * weighted.image.values[i] : 0; // which may not be finite
        if (!flags.empty())
            flags[i] = weight > 0 && weighted.clipped[i];
    }
    const auto means = [&](const std::vector<float>& of, std::uint32_t channels) { return resampled(of, channels, size, fewer, Wrap::Clamp, Wrap::Clamp); };
    result.image.values = means(weighted.image.values, 3);
    std::vector<float> weights = means(weighted.mask, 1);
    for (std::size_t i = 0; i < result.image.values.size(); ++i)
        result.image.values[i] /= weights[i / 3] > 0 ? weights[i / 3] : 1;
    if (!flags.empty())
        for (const float share : means(flags, 3))
            result.clipped.push_back(share > 0);
    constexpr float kWhole = 0.9999f; // but for rounding
    if (std::any_of(weights.begin(), weights.end(), [](float w) { return w < kWhole; })) {
        for (float& weight : weights)
            weight = weight < kWhole ? weight : 1;
        result.mask = std::move(weights);
    }
    return result;
}

cmpg::Target targetOf(const Target& target, std::size_t number) {
    if (target.image.values.empty() && target.read)
        return streamed([read = target.read, number] {
            Target whole = read();
            whole.read = nullptr; // its values are wanted now
            return targetOf(whole, number);
        });
    const std::string name = "target " + (target.name.empty() ? std::to_string(number) : target.name);
    const Image& image = target.image;
    if (image.channels != 3 || image.width < 1 || image.height < 1 || image.values.size() != image.pixels() * 3)
        throw Error(ErrorKind::Usage, name + " is no image of 3 channels, one value per pixel and channel");
    if (!target.mask.empty() && target.mask.size() != image.pixels())
        throw Error(ErrorKind::Usage,
                    "the mask of " + name + " has " + std::to_string(target.mask.size()) + " weights for " + std::to_string(image.pixels()) + " pixels",
                    {}, "give one weight per pixel", {"mask"});
    if (!target.clipped.empty() && target.clipped.size() != image.values.size())
        throw Error(ErrorKind::Usage, name + " says of " + std::to_string(target.clipped.size()) + " values whether they are clipped, and has " +
                                          std::to_string(image.values.size()));
    cmpg::Target result{.name = target.name.empty() ? std::to_string(number) : target.name, .image = image, .mask = target.mask, .clipped = target.clipped};
    for (const float weight : result.mask)
        if (!(weight >= 0 && weight <= 1))
            throw Error(ErrorKind::Usage, "the mask of " + name + " has weights out of [0, 1]", {}, "scale it", {"mask"});
    for (std::size_t p = 0; p < image.pixels(); ++p) {
        const float* pixel = image.values.data() + 3 * p;
        if (std::isfinite(pixel[0]) && std::isfinite(pixel[1]) && std::isfinite(pixel[2]))
            continue;
        if (result.mask.empty())
            result.mask.assign(image.pixels(), 1.f);
        result.mask[p] = 0;
        ++result.invalid;
    }
    if (!result.mask.empty() && std::all_of(result.mask.begin(), result.mask.end(), [](float w) { return w == 0; }))
        throw Error(ErrorKind::Input, "no pixel of " + name + " has a weight", "the mask is 0 or values are not finite everywhere",
                    "check mask and image", {"mask"});
    return result;
}

ImageLoss lossOf(Loss loss, const Image& image, const Target& target) {
    const cmpg::Target whole = targetOf(target.image.values.empty() && target.read ? target.read() : target, 0);
    LossResult found = evaluateLoss(loss, image, whole.image, whole.mask, whole.clipped);
    return {found.value, std::move(found.adjoint), found.nonFinite};
}

} // namespace cmpg::v1
