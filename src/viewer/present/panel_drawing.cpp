// Draws the images of a frame: textures by image, one pipeline, the colour maps.
#include "viewer/present/panel_drawing.h"

#include "imaging/display_image.h"
#include "imaging/signed_colors.h"

#include "panel_frag.h"
#include "panel_vert.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

constexpr std::uint32_t kMostTextures = 64; // shown at once; there are fewer panels

vk::raii::ShaderModule shaderModule(const GraphicsDevice& device, std::span<const std::uint32_t> code) {
    return device.device.createShaderModule({{}, code.size_bytes(), code.data()});
}

vk::raii::Pipeline makePipeline(const GraphicsDevice& device, vk::PipelineLayout layout, vk::RenderPass renderPass) {
    const vk::raii::ShaderModule vertex = shaderModule(device, panel_vert), fragment = shaderModule(device, panel_frag);
    const std::array stages{vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eVertex, *vertex, "main"),
                            vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eFragment, *fragment, "main")};
    const vk::PipelineVertexInputStateCreateInfo noVertices;
    const vk::PipelineInputAssemblyStateCreateInfo strip({}, vk::PrimitiveTopology::eTriangleStrip);
    const vk::PipelineViewportStateCreateInfo viewport({}, 1, nullptr, 1, nullptr);
    vk::PipelineRasterizationStateCreateInfo raster;
    raster.lineWidth = 1;
    const vk::PipelineMultisampleStateCreateInfo oneSample({}, vk::SampleCountFlagBits::e1);
    using C = vk::ColorComponentFlagBits;
    const vk::PipelineColorBlendAttachmentState over(true, vk::BlendFactor::eSrcAlpha, vk::BlendFactor::eOneMinusSrcAlpha, vk::BlendOp::eAdd,
                                                     vk::BlendFactor::eOne, vk::BlendFactor::eZero, vk::BlendOp::eAdd, C::eR | C::eG | C::eB | C::eA);
    const vk::PipelineColorBlendStateCreateInfo blending({}, false, {}, over);
    const std::array dynamic{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
    const vk::PipelineDynamicStateCreateInfo dynamicState({}, dynamic);
    return device.device.createGraphicsPipeline(nullptr, {{}, stages, &noVertices, &strip, nullptr, &viewport, &raster, &oneSample, nullptr,
                                                          &blending, &dynamicState, layout, renderPass, 0});
}

Image colorMaps() {
    Image maps(int(gpu::kPanelMapEntries), int(gpu::kPanelMaps), 3);
    for (int x = 0; x < maps.width; ++x) {
        const double t = double(x) / (maps.width - 1);
        const Color signedRow = signedColor(2 * t - 1), heatRow = heatColor(t), labelRow = labelColor(std::uint32_t(x));
        std::copy(signedRow.begin(), signedRow.end(), maps.at(x, int(gpu::kPanelMapSigned)));
        std::copy(heatRow.begin(), heatRow.end(), maps.at(x, int(gpu::kPanelMapHeat)));
        std::copy(labelRow.begin(), labelRow.end(), maps.at(x, int(gpu::kPanelMapLabels)));
    }
    return maps;
}

vk::Rect2D scissorOf(const Rectangle& clip, vk::Extent2D window) {
    const auto edge = [](float value, std::uint32_t most) { return std::clamp(std::lround(value), 0l, long(most)); };
    const long left = edge(clip.x, window.width), top = edge(clip.y, window.height);
    const long right = edge(clip.right(), window.width), bottom = edge(clip.bottom(), window.height);
    return {{std::int32_t(left), std::int32_t(top)}, {std::uint32_t(std::max(0l, right - left)), std::uint32_t(std::max(0l, bottom - top))}};
}

} // namespace

PanelDrawing::PanelDrawing(const GraphicsDevice& device, vk::RenderPass renderPass) : device_(device) {
    const vk::DescriptorSetLayoutBinding binding(0, vk::DescriptorType::eSampledImage, 1, vk::ShaderStageFlagBits::eFragment);
    setLayout_ = device.device.createDescriptorSetLayout({{}, binding});
    const vk::DescriptorPoolSize size(vk::DescriptorType::eSampledImage, kMostTextures);
    pool_ = device.device.createDescriptorPool({vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, kMostTextures, size});
    const std::array sets{*setLayout_, *setLayout_};
    const vk::PushConstantRange push(vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0, sizeof(gpu::PanelPush));
    layout_ = device.device.createPipelineLayout({{}, sets, push});
    pipeline_ = makePipeline(device, *layout_, renderPass);

    const Image maps = colorMaps();
    maps_ = std::make_unique<Texture>(device, maps);
    maps_->set(maps);
    mapsSet_ = describe(*maps_);
    device.runOnce([&](const vk::raii::CommandBuffer& commands) { maps_->record(commands); });
}

vk::raii::DescriptorSet PanelDrawing::describe(const Texture& texture) const {
    vk::raii::DescriptorSets sets(device_.device, {*pool_, *setLayout_});
    const vk::DescriptorImageInfo info({}, texture.view(), vk::ImageLayout::eShaderReadOnlyOptimal);
    device_.device.updateDescriptorSets(vk::WriteDescriptorSet(*sets[0], 0, 0, vk::DescriptorType::eSampledImage, info), nullptr);
    return std::move(sets[0]);
}

PanelDrawing::Shown PanelDrawing::make(const std::shared_ptr<const Image>& image) const {
    Texture texture(device_, *image);
    vk::raii::DescriptorSet set = describe(texture);
    return {image, std::move(texture), std::move(set)};
}

void PanelDrawing::upload(const vk::raii::CommandBuffer& commands, std::span<const PanelQuad> quads) {
    spare_.clear(); // of the frame before: nobody took them
    const auto wanted = [&](const Shown& s) { return std::any_of(quads.begin(), quads.end(), [&](const PanelQuad& q) { return q.image == s.image; }); };
    const auto kept = std::stable_partition(shown_.begin(), shown_.end(), wanted);
    spare_.assign(std::make_move_iterator(kept), std::make_move_iterator(shown_.end()));
    shown_.erase(kept, shown_.end());
    for (const PanelQuad& quad : quads) {
        if (!quad.image || std::any_of(shown_.begin(), shown_.end(), [&](const Shown& s) { return s.image == quad.image; }))
            continue;
        // A picture is mostly followed by its next state, of the same shape.
        const auto like = std::find_if(spare_.begin(), spare_.end(), [&](const Shown& s) { return s.texture.fits(*quad.image); });
        if (like != spare_.end()) {
            shown_.push_back(std::move(*like));
            spare_.erase(like);
            shown_.back().image = quad.image;
        } else {
            shown_.push_back(make(quad.image));
        }
        shown_.back().texture.set(*quad.image);
    }
    for (Shown& shown : shown_)
        shown.texture.record(commands);
}

void PanelDrawing::draw(const vk::raii::CommandBuffer& commands, std::span<const PanelQuad> quads, vk::Extent2D window) {
    const vk::PipelineBindPoint graphics = vk::PipelineBindPoint::eGraphics;
    commands.bindPipeline(graphics, *pipeline_);
    commands.setViewport(0, vk::Viewport(0, 0, float(window.width), float(window.height), 0, 1));
    for (const PanelQuad& quad : quads) {
        const vk::Rect2D scissor = scissorOf(quad.clip, window);
        if (scissor.extent.width == 0 || scissor.extent.height == 0)
            continue;
        gpu::PanelPush push{};
        push.place = {quad.place.x, quad.place.y};
        push.extent = {quad.place.width, quad.place.height};
        push.window = {float(window.width), float(window.height)};
        push.kind = quad.kind;
        push.factor = quad.factor;
        push.decades = quad.decades;
        push.opacity = quad.opacity;
        push.background = quad.background;
        vk::DescriptorSet set = *mapsSet_; // a plain rectangle reads none, but something must be bound
        const auto shown = std::find_if(shown_.begin(), shown_.end(), [&](const Shown& s) { return s.image == quad.image; });
        if (quad.image && shown != shown_.end()) {
            set = *shown->set;
            push.width = gpu::uint(shown->texture.width());
            push.height = gpu::uint(shown->texture.height());
            push.channels = gpu::uint(quad.image->channels);
        }
        commands.setScissor(0, scissor);
        commands.bindDescriptorSets(graphics, *layout_, 0, {set, *mapsSet_}, nullptr);
        commands.pushConstants<gpu::PanelPush>(*layout_, vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0, push);
        commands.draw(4, 1, 0, 0);
    }
}

} // namespace cmpg::viewer
