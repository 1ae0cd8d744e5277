#pragma once

// A renderer for tests and benchmarks: ray tracing with a beam through each pixel's centre.

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/fields.h"
#include "methods/method.h"
#include "passes/renderer.h"

namespace scanmill {

// The beams through the centres of a camera's pixels, in its own axes; they start in the near plane.
inline std::shared_ptr<BeamTable> pixelBeams(const Camera& camera, const DrawLimits& limits) {
  auto beams = std::make_shared<BeamTable>();
  beams->model = "camera";
  beams->rings = camera.height;
  beams->columns = camera.width;
  beams->direction.reserve(camera.pixels());
  beams->origin.reserve(camera.pixels());
  double longest = 1;
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    for (std::uint32_t column = 0; column < camera.width; ++column) {
      const Vec3d ray = camera.ray(column + 0.5, row + 0.5);
      longest = std::max(longest, length(ray));
      beams->direction.push_back(normalized(ray));
      beams->origin.push_back(Vec3f(ray * limits.nearest));
    }
  }
  beams->time.assign(camera.pixels(), 0.0f);
  beams->maxRange = limits.farthest * longest;
  beams->period = 0.1;
  beams->elevation.assign(camera.height, 0.0);
  beams->azimuthOffset.assign(camera.height, 0.0);
  beams->firingOffset.assign(camera.height, 0.0);
  return beams;
}

class EmbreePasses : public PassRenderer {
 public:
  explicit EmbreePasses(const Scene& scene) : scene_(scene) {
    const Value value = parseYaml("{}", "options");
    Fields fields(value, "method ray_tracing");
    method_ = requireMethod("ray_tracing", {}).make(scene, fields);
  }

  std::unique_ptr<PixelSource> draw(const std::vector<Camera>& cameras, const DrawLimits& limits,
                                    PassChoice choice) override {
    drawnPixels_ = 0;
    std::vector<PassImage> images;
    for (const Camera& camera : cameras) {
      images.push_back(image(camera, limits, choice));
      drawnPixels_ += camera.pixels();
    }
    ++draws_;
    return std::make_unique<OwningSource>(std::move(images));
  }

  PassImage image(const Camera& camera, const DrawLimits& limits, PassChoice choice) const {
    Shot shot;
    shot.beams = pixelBeams(camera, limits);
    shot.worldFromSensor = {camera.worldFromCamera};
    Hits hits;
    method_->trace(shot, choice.channels | (choice.surfaceParameters ? Channels(Channel::Material) : Channels()), hits);
    PassImage made{camera, {}};
    PassPlanes& planes = made.planes;
    planes.reset(camera.pixels(), choice);
    for (std::size_t i = 0; i < camera.pixels(); ++i) {
      const double forward = shot.beams->direction[i].z;
      const double depth = hits.hit(i) ? double{hits.range[i]} * forward + limits.nearest : INFINITY;
      const bool seen = depth <= limits.farthest;
      planes.depth[i] = seen ? static_cast<float>(depth) : kNoDepth;
      const auto copy = [&](auto& to, const auto& from) {
        if (!to.empty()) to[i] = seen ? from[i] : typename std::decay_t<decltype(to)>::value_type{};
      };
      copy(planes.normal, hits.normal);
      copy(planes.instance, hits.instance);
      copy(planes.semantic, hits.semantic);
      copy(planes.material, hits.material);
      copy(planes.primitive, hits.primitive);
      copy(planes.reflectance, hits.reflectance);
      if (!choice.surfaceParameters) continue;
      const Material& material = scene_.materials[hits.material[i]];
      planes.roughness[i] = seen ? material.roughness : 0;
      planes.metallic[i] = seen ? material.metallic : 0;
      planes.retroreflectance[i] = seen ? material.retroreflectance : 0;
    }
    return made;
  }

  std::string device() const override { return "Embree"; }

  std::size_t draws() const { return draws_; }              // so far
  std::size_t drawnPixels() const { return drawnPixels_; }  // of the last draw

 private:
  class OwningSource : public PixelSource {
   public:
    explicit OwningSource(std::vector<PassImage> images) : images_(std::move(images)), source_(images_) {}
    const std::vector<Camera>& cameras() const override { return source_.cameras(); }
    PassChoice available() const override { return source_.available(); }
    void fetch(std::span<const PixelAddress> addresses, PassChoice asked, PassPlanes& planes) override {
      source_.fetch(addresses, asked, planes);
    }

   private:
    std::vector<PassImage> images_;
    ImageSource source_;
  };

  const Scene& scene_;
  std::unique_ptr<Method> method_;
  std::size_t draws_ = 0;
  std::size_t drawnPixels_ = 0;
};

}  // namespace scanmill
