// An image in the memory of the device that draws.
#include "viewer/present/texture.h"

namespace cmpg::viewer {
namespace {

constexpr vk::ImageSubresourceRange kWhole(vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1);

int thinning(const Image& shape, std::uint32_t maxEdge) {
    return (std::max(shape.width, shape.height) + int(maxEdge) - 1) / int(maxEdge);
}

} // namespace

Texture::Texture(const GraphicsDevice& device, const Image& shape)
    : stride_(thinning(shape, device.maxEdge)), imageWidth_(shape.width), imageHeight_(shape.height),
      width_((shape.width + stride_ - 1) / stride_), height_((shape.height + stride_ - 1) / stride_), imageChannels_(shape.channels),
      channels_(shape.channels == 1 ? 1 : 4) {
    const vk::Format format = channels_ == 1 ? vk::Format::eR32Sfloat : vk::Format::eR32G32B32A32Sfloat;
    image_ = device.device.createImage({{}, vk::ImageType::e2D, format, {std::uint32_t(width_), std::uint32_t(height_), 1}, 1, 1,
                                        vk::SampleCountFlagBits::e1, vk::ImageTiling::eOptimal,
                                        vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferDst});
    memory_ = device.allocate(image_.getMemoryRequirements(), vk::MemoryPropertyFlagBits::eDeviceLocal);
    image_.bindMemory(*memory_, 0);
    view_ = device.device.createImageView({{}, *image_, vk::ImageViewType::e2D, format, {}, kWhole});

    staging_ = device.device.createBuffer({{}, sizeof(float) * std::size_t(width_) * std::size_t(height_) * std::size_t(channels_),
                                           vk::BufferUsageFlagBits::eTransferSrc});
    stagingMemory_ = device.allocate(staging_.getMemoryRequirements(),
                                     vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
    staging_.bindMemory(*stagingMemory_, 0);
    mapped_ = static_cast<float*>(stagingMemory_.mapMemory(0, VK_WHOLE_SIZE));
}

bool Texture::fits(const Image& image) const {
    return image.width == imageWidth_ && image.height == imageHeight_ && image.channels == imageChannels_;
}

void Texture::set(const Image& image) {
    float* to = mapped_;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const float* from = image.at(x * stride_, y * stride_);
            for (int c = 0; c < channels_; ++c)
                *to++ = c < image.channels ? from[c] : 1;
        }
    pending_ = true;
}

void Texture::record(const vk::raii::CommandBuffer& commands) {
    if (!pending_)
        return;
    pending_ = false;
    const auto read = vk::ImageLayout::eShaderReadOnlyOptimal, write = vk::ImageLayout::eTransferDstOptimal;
    const vk::ImageMemoryBarrier toWrite(filled_ ? vk::AccessFlagBits::eShaderRead : vk::AccessFlags{}, vk::AccessFlagBits::eTransferWrite,
                                         vk::ImageLayout::eUndefined, write, VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED, *image_, kWhole);
    commands.pipelineBarrier(filled_ ? vk::PipelineStageFlagBits::eFragmentShader : vk::PipelineStageFlagBits::eTopOfPipe,
                             vk::PipelineStageFlagBits::eTransfer, {}, nullptr, nullptr, toWrite);
    commands.copyBufferToImage(*staging_, *image_, write,
                               vk::BufferImageCopy(0, 0, 0, {vk::ImageAspectFlagBits::eColor, 0, 0, 1}, {},
                                                   {std::uint32_t(width_), std::uint32_t(height_), 1}));
    const vk::ImageMemoryBarrier toRead(vk::AccessFlagBits::eTransferWrite, vk::AccessFlagBits::eShaderRead, write, read, VK_QUEUE_FAMILY_IGNORED,
                                        VK_QUEUE_FAMILY_IGNORED, *image_, kWhole);
    commands.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer, vk::PipelineStageFlagBits::eFragmentShader, {}, nullptr, nullptr, toRead);
    filled_ = true;
}

} // namespace cmpg::viewer
