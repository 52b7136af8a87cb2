// A target image with the weight each of its pixels has in the loss.
#include "optimize/target.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

std::string sizeText(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

Image threeChannels(Image image) {
    if (image.channels == 3)
        return image;
    Image grey(image.width, image.height, 3);
    for (std::size_t p = 0; p < image.pixels(); ++p)
        std::fill_n(grey.values.data() + 3 * p, 3, image.values[p * image.channels]);
    return grey;
}

// Of three channels, where there may be one.
std::vector<std::uint8_t> perChannel(const std::vector<std::uint8_t>& flags, int channels) {
    if (channels == 3)
        return flags;
    std::vector<std::uint8_t> three;
    three.reserve(3 * flags.size());
    for (const std::uint8_t flag : flags)
        three.insert(three.end(), 3, flag);
    return three;
}

// Multiplies the weights by the mean channel of an image.
void applyMask(Target& target, const std::filesystem::path& file) {
    const Image mask = threeChannels(readImage(file, {.linear = true, .finite = false}).image);
    if (mask.width != target.image.width || mask.height != target.image.height)
        throw Error(ErrorKind::Input,
                    "mask " + file.string() + " is " + sizeText(mask.width, mask.height) + ", its target " + target.name + " is " +
                        sizeText(target.image.width, target.image.height),
                    "it was made for another image", "give a mask of the target's size");
    for (std::size_t p = 0; p < mask.pixels(); ++p) {
        const float mean = (mask.values[3 * p] + mask.values[3 * p + 1] + mask.values[3 * p + 2]) / 3;
        target.mask[p] *= std::isfinite(mean) ? std::clamp(mean, 0.f, 1.f) : 0.f;
    }
}

} // namespace

Target loadTarget(const std::filesystem::path& file, const TargetOptions& options) {
    ReadImage read = readImage(file, {.finite = false});
    Target target;
    target.name = file.string();
    if (std::any_of(read.clipped.begin(), read.clipped.end(), [](std::uint8_t c) { return c != 0; }))
        target.clipped = perChannel(read.clipped, read.image.channels);
    target.image = threeChannels(std::move(read.image));
    target.mask.assign(target.image.pixels(), 1.f);
    for (std::size_t p = 0; p < read.alpha.size(); ++p)
        target.mask[p] = std::isfinite(read.alpha[p]) ? std::clamp(read.alpha[p], 0.f, 1.f) : 0.f;
    if (!options.mask.empty())
        applyMask(target, options.mask);

    const float scale = std::exp2(options.exposure);
    double total = 0;
    for (std::size_t p = 0; p < target.image.pixels(); ++p) {
        float* pixel = target.image.values.data() + 3 * p;
        bool finite = true;
        for (int c = 0; c < 3; ++c) {
            pixel[c] *= scale;
            finite = finite && std::isfinite(pixel[c]);
        }
        target.invalid += !finite;
        if (!finite)
            target.mask[p] = 0;
        total += target.mask[p];
    }
    if (total == 0)
        throw Error(ErrorKind::Input, "no pixel of target " + target.name + " counts",
                    "alpha and mask are 0 or values are not finite everywhere",
                    "check the alpha channel and the mask", {"mask"});
    if (std::all_of(target.mask.begin(), target.mask.end(), [](float w) { return w == 1; }))
        target.mask.clear();
    return target;
}

void requireSize(const Target& target, int width, int height) {
    if (target.image.width == width && target.image.height == height)
        return;
    throw Error(ErrorKind::Input,
                "target " + target.name + " is " + sizeText(target.image.width, target.image.height) + ", the image " +
                    sizeText(width, height),
                "the size asked for differs from the target's, or the targets of several cameras differ in size",
                "leave the size to the target, or resample the target to " + sizeText(width, height), {"width", "height"});
}

} // namespace cmpg
