// Targets of the library's surface, and the loss of an image against one.
#include "library/targets.h"

#include "base/error.h"
#include "optimize/loaded_target.h"
#include "optimize/losses.h"

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
