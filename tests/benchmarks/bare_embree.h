#pragma once

// What Embree alone costs: the yardstick of our trace stage.

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "scene/embree.h"
#include "scene/scene.h"
#include "sensors/beams.h"

namespace scanmill {

// The same triangles in one Embree geometry without filters, in the order of instances and their triangles.
class BareScene {
 public:
  // `origin` becomes the origin, so that float32 suffices.
  BareScene(const Scene& from, const Vec3d& origin) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    for (const Instance& instance : from.instances) {
      const Mesh& mesh = from.meshes[instance.mesh];
      const auto base = static_cast<std::uint32_t>(positions_.size());
      for (const Vec3f& p : mesh.positions) positions_.push_back(Vec3f(instance.worldFromMesh * Vec3d(p) - origin));
      for (const Triangle& t : mesh.triangles) triangles_.push_back({t[0] + base, t[1] + base, t[2] + base});
    }
    positions_.emplace_back();
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions_.data(), 0,
                               sizeof(Vec3f), positions_.size() - 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles_.data(), 0,
                               sizeof(Triangle), triangles_.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene_);
  }
  ~BareScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareScene(const BareScene&) = delete;
  BareScene& operator=(const BareScene&) = delete;

  RTCScene get() const { return scene_; }

 private:
  RTCDevice device_;
  RTCScene scene_;
  std::vector<Vec3f> positions_;
  std::vector<Triangle> triangles_;
};

// Packets in the better of two orders.
class BareEmbree {
 public:
  // Beams leave from `sensor`, which becomes the origin.
  BareEmbree(const Scene& from, const BeamTable& beams, const Vec3d& sensor = {}) : scene_(from, sensor) {
    for (const bool byRing : {false, true}) {
      std::vector<RTCRay16> packets(beams.size() / 16);
      for (std::size_t i = 0; i < packets.size() * 16; ++i) {
        const std::size_t ring = byRing ? i % beams.rings : i / beams.columns;
        const std::size_t column = byRing ? i / beams.rings : i % beams.columns;
        put(packets[i / 16], i % 16, beams.direction[ring * beams.columns + column], beams.maxRange);
      }
      orders_.push_back(std::move(packets));
    }
  }

  void trace(std::size_t order) {
    const std::vector<RTCRay16>& packets = orders_[order];
    results_.resize(packets.size());
    parallelFor(packets.size(), 128, [&](std::size_t first, std::size_t last) {
      alignas(64) int valid[16];
      std::fill_n(valid, 16, -1);
      for (std::size_t i = first; i < last; ++i) {
        EmbreeContext context = newEmbreeContext();
        RTCRayHit16& r = results_[i];
        r.ray = packets[i];
        std::fill_n(r.hit.geomID, 16, RTC_INVALID_GEOMETRY_ID);
        std::fill_n(r.hit.instID[0], 16, RTC_INVALID_GEOMETRY_ID);
        intersectPacket(scene_.get(), context, valid, r);
      }
    });
  }

 private:
  static void put(RTCRay16& p, std::size_t i, const Vec3d& d, double far) {
    p.org_x[i] = p.org_y[i] = p.org_z[i] = p.tnear[i] = p.time[i] = 0;
    p.dir_x[i] = static_cast<float>(d.x);
    p.dir_y[i] = static_cast<float>(d.y);
    p.dir_z[i] = static_cast<float>(d.z);
    p.tfar[i] = static_cast<float>(far);
    p.mask[i] = ~0u;
    p.id[i] = static_cast<unsigned>(i);
    p.flags[i] = 0;
  }

  BareScene scene_;
  std::vector<std::vector<RTCRay16>> orders_;
  std::vector<RTCRayHit16> results_;
};

}  // namespace scanmill
