// The guide of a renderer: the tree, its copy on the device, and the units of the records between two updates.
#pragma once

#include "base/communicator.h"
#include "guiding/field/guide_buffers.h"
#include "render/integer_scale.h"
#include "render/renderer.h"
#include "scene/features.h"

namespace cmpg {

struct Guide {
    SdTree tree;
    GuideBuffers buffers;

    Guide(Device& device, const Scene& scene, const RenderConfig& config);

    // Tells the kernels of a pass of `spp` samples per pixel on average what to do with the guide.
    void beginPass(const FeatureSet::Pass& pass, const PassPlan& plan, std::uint32_t spp);
    // Fixes the units of records until the next update: from what the tree knows, else from `pilot`, the mean radiance of the scene.
    // Derivatives by normals grow by 1 / shortestNormal.
    template <class Pilot> void openRecords(Pilot&& pilot, double shortestNormal) {
        if (open_)
            return;
        const double mean = tree.empty() ? pilot() : meanRadiance();
        setUnits(mean > 0 ? mean : 1, shortestNormal);
    }
    UpdateReport update(bool forget); // of the tree on the host; see Renderer::updateGuide()
    void publish();                   // what update() left, if it is not on the device yet
    void valuesChanged() { valuesChanged_ = true; } // of parameters, so what is known is of other ones
    void discardRecords();
    void replace(SdTree other);

  private:
    double meanRadiance() const;
    void setUnits(double radiance, double shortestNormal);

    Communicator& ranks_;
    std::uint64_t mostNodes_; // that surely fit
    bool emission_; // derivatives by emission have no unit of radiance
    float share_;
    double rouletteEffort_;
    bool open_ = false, published_ = true, valuesChanged_ = false;
    double primalUnit_ = 1, derivativeUnit_ = 1;
    gpu::GuideInfo info_{};
};

} // namespace cmpg
