#pragma once

// Computes the values of all passes from the two values that a renderer gives for each pixel: a triangle and a depth.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "passes/pass_image.h"
#include "scene/reflectance.h"
#include "scene/scene.h"

namespace scanmill {

// The triangle that is visible at a pixel, and its depth.
struct VisibleTriangle {
  float depth = kNoDepth;      // m, planar: along the camera's z axis
  std::uint32_t instance = 0;  // 1 + index into Scene::instances; 0: no surface
  std::uint32_t triangle = 0;  // index into Mesh::triangles
};

// Normals, labels and materials are computed in double precision from the scene's triangles, so that they are exact
// with any renderer. A resolver may be used by several threads at once. The scene must outlive the resolver.
class Resolver {
 public:
  explicit Resolver(const Scene& scene);
  Resolver& operator=(Resolver&&) = delete;  // neither copied nor moved

  // Fills `planes` with one entry per entry of `triangles`. addresses[i] is the pixel in the cameras' images that shows
  // triangles[i]; kNoPixel if no pixel does. Normals are turned against the line of sight through the pixel's centre. A
  // textured material has the reflectance of the visible texel.
  void resolve(std::span<const Camera> cameras, std::span<const PixelAddress> addresses,
               std::span<const VisibleTriangle> triangles, PassChoice requested, PassPlanes& planes) const;

 private:
  // All values of a triangle in one record: pixels access triangles at random, and a record takes few cache lines.
  struct Face {
    Vec3d normal;               // unit vector, mesh axes
    std::uint32_t surface = 0;  // index into surfaces_
  };
  struct PlacedMesh {
    Mat3 normalFromMesh;          // matrix of cofactors of the instance's linear part
    const Face* faces = nullptr;  // the mesh's triangles, in faces_
    std::uint32_t firstInstanceId = 0;
  };
  struct SurfaceIds {
    std::uint32_t object = 0;
    std::uint16_t semantic = 0;
    std::uint16_t material = 0;
  };
  struct MaterialValues {
    CompactMaterial reflecting;
    float roughness = 0;
    float metallic = 0;
    float retroreflectance = 0;
  };
  struct Job;
  struct PixelBlock;

  PixelBlock gatherBlock(const Job& job, std::size_t first, std::size_t end) const;
  void storeSurfaces(const Job& job, const PixelBlock& block) const;
  static void storeNormals(const Job& job, const PixelBlock& block);
  float texturedReflectance(const VisibleTriangle& visible, const CompactMaterial& material, const Vec3d& eye,
                            const Vec3d& sight) const;

  const Scene& scene_;
  std::vector<Face> faces_;            // the triangles of all meshes, one mesh after the other
  std::vector<SurfaceIds> surfaces_;   // the surfaces of all meshes, one mesh after the other
  std::vector<PlacedMesh> instances_;  // indexed by VisibleTriangle::instance; 0: pixels without a surface
  std::vector<MaterialValues> materials_;
};

}  // namespace scanmill
