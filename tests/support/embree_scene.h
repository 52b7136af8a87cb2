// Embree 3 as oracle and yardstick: single-ray queries over a geometry.
#pragma once

#include "scene/scene.h"
#include "shared/wavefront.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <embree3/rtcore.h>
#include <thread>

namespace cmpg::test {

class EmbreeScene {
  public:
    // `robust`: Embree's watertight mode, as an oracle; without it Embree's fastest, as a yardstick.
    EmbreeScene(const Geometry& g, bool robust) : device_(rtcNewDevice("threads=2")), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        void* positions = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), g.positions.size());
        std::memcpy(positions, g.positions.data(), g.positions.size() * sizeof(glm::vec3));
        auto* indices = static_cast<std::uint32_t*>(
            rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), g.triangles.size()));
        for (std::size_t i = 0; i < g.triangles.size(); ++i)
            std::copy_n(g.triangles[i].vertices.begin(), 3, indices + 3 * i);
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_);
    }
    ~EmbreeScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    struct Answer {
        float t; // < 0: nothing met
        std::uint32_t triangle;
        glm::vec3 normal; // geometric, not normalised
    };

    Answer intersect(const gpu::Ray& ray) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit query{};
        query.ray.org_x = ray.origin.x, query.ray.org_y = ray.origin.y, query.ray.org_z = ray.origin.z;
        query.ray.dir_x = ray.direction.x, query.ray.dir_y = ray.direction.y, query.ray.dir_z = ray.direction.z;
        query.ray.tfar = std::numeric_limits<float>::infinity();
        query.ray.mask = ~0u;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene_, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return {-1, ~0u, {}};
        return {query.ray.tfar, query.hit.primID, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}};
    }

    // All rays, one at a time, on `threads` threads.
    std::vector<Answer> intersect(const std::vector<gpu::Ray>& rays, unsigned threads = 2) const {
        std::vector<Answer> answers(rays.size());
        std::atomic<std::size_t> next{0};
        constexpr std::size_t kChunk = 4096;
        const auto work = [&] {
            for (std::size_t begin; (begin = next.fetch_add(kChunk)) < rays.size();)
                for (std::size_t i = begin; i < std::min(rays.size(), begin + kChunk); ++i)
                    answers[i] = intersect(rays[i]);
        };
        std::vector<std::thread> helpers;
        for (unsigned i = 1; i < threads; ++i)
            helpers.emplace_back(work);
        work();
        for (std::thread& h : helpers)
            h.join();
        return answers;
    }

  private:
    RTCDevice device_;
    RTCScene scene_;
};

} // namespace cmpg::test
