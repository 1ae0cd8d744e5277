#pragma once

// Reflectance and transparency at a point of a triangle, for ray tracing and rendered images alike.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// The fields of Material that are needed for the reflectance at a hit; small, since strings are left out.
struct CompactMaterial {
  float reflectance = 0;
  float textureGain = 0;             // reflectance / mean luminance of the texture; 0 if not textured
  const Texture* texture = nullptr;  // null: no texture scales the reflectance

  // Returns the reflectance at these texture coordinates: the texture's luminance at that point, scaled so that the
  // texture's mean luminance gives the material's reflectance, and at most 1. The material must be textured.
  float texturedAt(const Vec2f& uv) const;
  float ofTexel(const std::uint8_t* texel) const;  // returns the reflectance at a texel (RGBA)
};

CompactMaterial compact(const Material& material);
// Returns the compact materials of Scene::materials, in the same order.
std::vector<CompactMaterial> compactMaterials(const Scene& scene);

// Returns the barycentric coordinates of a point in a triangle's plane, clamped to the triangle: the weights of the
// second and of the third corner. The edges `ab` and `ac` and `point` are relative to the first corner (m, same frame).
inline Vec2d barycentric(const Vec3d& ab, const Vec3d& ac, const Vec3d& point) {
  const Vec3d normal = cross(ab, ac);
  const double squaredLength = dot(normal, normal);
  const double u = std::clamp(dot(normal, cross(point, ac)) / squaredLength, 0.0, 1.0);
  const double v = std::clamp(dot(normal, cross(ab, point)) / squaredLength, 0.0, 1.0 - u);
  return {u, v};
}

// Returns the texture coordinates at a point of a triangle; (0, 0) if `uvs` is empty. `uvs`: one entry per vertex;
// `weights`: the point's barycentric().
inline Vec2f textureCoordinates(const std::vector<Vec2f>& uvs, const Triangle& corners, const Vec2d& weights) {
  if (uvs.empty()) return {};
  const Vec2f& a = uvs[corners[0]];
  const Vec2f& b = uvs[corners[1]];
  const Vec2f& c = uvs[corners[2]];
  const auto [weightB, weightC] = weights;
  const double weightA = 1 - weightB - weightC;
  return {static_cast<float>(weightA * a.x + weightB * b.x + weightC * c.x),
          static_cast<float>(weightA * a.y + weightB * b.y + weightC * c.y)};
}

// True if an alpha-tested material lets beams pass at a texel (RGBA) of its texture.
inline bool letsPass(const Material& material, const std::uint8_t* texel) {
  return static_cast<float>(texel[3]) < material.alphaCutoff * 255.0f;
}

}  // namespace scanmill
