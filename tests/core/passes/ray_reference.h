#pragma once

// What a pinhole sees of a small scene, by brute force in double: every triangle at every pixel's centre.

#include <vector>

#include "passes/pass_image.h"
#include "passes/renderer.h"
#include "scene/scene.h"

namespace scanmill {

struct ReferencePixel {
  double depth = INFINITY;
  std::uint32_t instance = 0;  // 1 + index into Scene::instances; 0: nothing
  std::uint32_t triangle = 0;
};

class RayReference {
 public:
  explicit RayReference(const Scene& scene) : scene_(scene) {}

  std::vector<ReferencePixel> draw(const Camera& camera, const DrawLimits& limits) const {
    std::vector<ReferencePixel> image(camera.pixels());
    const Affine cameraFromWorld = inverse(toAffine(camera.worldFromCamera));
    for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      const Mesh& mesh = scene_.meshes[instance.mesh];
      // The translations of a scene far from the world's origin cancel first.
      const Affine moved{instance.worldFromMesh.linear,
                         instance.worldFromMesh.translation - camera.worldFromCamera.translation};
      const Affine cameraFromMesh{cameraFromWorld.linear * moved.linear, cameraFromWorld.linear * moved.translation};
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        drawTriangle(camera, limits, i, t, cameraFromMesh, image);
    }
    return image;
  }

 private:
  void drawTriangle(const Camera& camera, const DrawLimits& limits, std::uint32_t i, std::uint32_t t,
                    const Affine& cameraFromMesh, std::vector<ReferencePixel>& image) const {
    const Mesh& mesh = scene_.meshes[scene_.instances[i].mesh];
    const Triangle& corners = mesh.triangles[t];
    const Vec3d a = cameraFromMesh * Vec3d(mesh.positions[corners[0]]);
    const Vec3d b = cameraFromMesh * Vec3d(mesh.positions[corners[1]]);
    const Vec3d c = cameraFromMesh * Vec3d(mesh.positions[corners[2]]);
    if (std::max({a.z, b.z, c.z}) < limits.nearest || std::min({a.z, b.z, c.z}) > limits.farthest) return;
    const Vec3d normal = cross(b - a, c - a);
    const double scale = 1 / dot(normal, normal);
    for (std::uint32_t row = 0; row < camera.height; ++row) {
      for (std::uint32_t column = 0; column < camera.width; ++column) {
        ReferencePixel& pixel = image[std::size_t{row} * camera.width + column];
        const Vec3d ray = camera.ray(column + 0.5, row + 0.5);  // depth 1
        const double depth = dot(a, normal) / dot(ray, normal);
        if (!(depth >= limits.nearest && depth <= limits.farthest && depth < pixel.depth)) continue;
        const Vec3d p = ray * depth - a;
        const double v = dot(cross(p, c - a), normal) * scale;
        const double w = dot(cross(b - a, p), normal) * scale;
        if (v < 0 || w < 0 || v + w > 1 || isHole(mesh, t, v, w)) continue;
        pixel = {depth, i + 1, t};
      }
    }
  }

  bool isHole(const Mesh& mesh, std::uint32_t t, double v, double w) const {
    const Material& material = scene_.materials[mesh.surfaces[mesh.surfaceOf[t]].material];
    if (!material.alphaTested) return false;
    const Triangle& corners = mesh.triangles[t];
    const Vec2f a = mesh.uvs[corners[0]];
    const Vec2f b = mesh.uvs[corners[1]];
    const Vec2f c = mesh.uvs[corners[2]];
    const double u = 1 - v - w;
    const std::uint8_t* texel = material.texture->texel(static_cast<float>(u * a.x + v * b.x + w * c.x),
                                                        static_cast<float>(u * a.y + v * b.y + w * c.y));
    return static_cast<float>(texel[3]) < material.alphaCutoff * 255.0f;
  }

  const Scene& scene_;
};

// Whether all pixels around one, and itself, see the same triangle.
inline bool isInside(const std::vector<ReferencePixel>& image, const Camera& camera, std::size_t pixel) {
  const auto column = static_cast<int>(pixel % camera.width);
  const auto row = static_cast<int>(pixel / camera.width);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = column + dx;
      const int y = row + dy;
      if (x < 0 || y < 0 || x >= static_cast<int>(camera.width) || y >= static_cast<int>(camera.height)) continue;
      const ReferencePixel& near = image[static_cast<std::size_t>(y) * camera.width + static_cast<std::size_t>(x)];
      if (near.instance != image[pixel].instance || near.triangle != image[pixel].triangle) return false;
    }
  }
  return true;
}

}  // namespace scanmill
