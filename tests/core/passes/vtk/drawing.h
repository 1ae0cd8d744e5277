#pragma once

// Scenes and cameras for tests of the VTK renderer, and a judge: every pixel against a reference in double precision.

#include <memory>
#include <utility>
#include <vector>

#include "base/random.h"
#include "passes/renderer.h"
#include "tests/core/passes/ray_reference.h"
#include "tests/support/gl.h"
#include "tests/support/test_scene.h"

namespace scanmill {
inline const PassChoice kIds{Channels(Channel::Instance) | Channel::Primitive | Channel::Normal | Channel::Material,
                             false};

#define RENDERER_OR_SKIP(name, scene) \
  SKIP_WITHOUT_GL();                  \
  const std::unique_ptr<PassRenderer> name = makeVtkRenderer(scene)

inline Camera cameraAt(const Vec3d& position, double yawDeg, double pitchDeg, double rollDeg, std::uint32_t width,
                       std::uint32_t height, double fieldDeg) {
  Camera camera = squareCamera(width, height, radians(fieldDeg));
  const Quat heading = fromYawPitchRoll(radians(yawDeg), radians(pitchDeg), radians(rollDeg));
  camera.worldFromCamera = {heading * vehicleFromOptical(), position};
  camera.name = "test";
  return camera;
}

inline std::vector<PassImage> drawn(PassRenderer& renderer, const std::vector<Camera>& cameras,
                                    const DrawLimits& limits, PassChoice choice = kIds) {
  const auto source = renderer.draw(cameras, limits, choice);
  return readAll(*source, choice);
}

inline PassPlanes drawnOne(PassRenderer& renderer, const Camera& camera, const DrawLimits& limits = {}) {
  return drawn(renderer, {camera}, limits).front().planes;
}

inline bool same(const PassPlanes& a, const PassPlanes& b) {
  return a.depth == b.depth && a.instance == b.instance && a.primitive == b.primitive && a.normal == b.normal &&
         a.material == b.material;
}

inline std::size_t seenPixels(const PassPlanes& planes) {
  return static_cast<std::size_t>(
      std::count_if(planes.depth.begin(), planes.depth.end(), [](float depth) { return depth != kNoDepth; }));
}

// Numbers in [low, high) that follow from their index.
inline double uniform(std::uint32_t index, double low, double high) {
  const RandomBlock block = randomBlock({.seed = 7, .beam = index});
  return low + (high - low) * (block[0] / 4294967296.0);
}

inline Vec3d uniformPoint(std::uint32_t& index, double reach) {
  const double x = uniform(index++, -reach, reach);
  const double y = uniform(index++, -reach, reach);
  return {x, y, uniform(index++, -reach, reach)};
}

// Loose triangles around the origin, in meshes placed turned, stretched and mirrored.
inline Scene randomScene(const Vec3d& where = {}, double size = 1) {
  SceneBuilder builder = testBuilder();
  std::uint32_t next = 0;
  for (int m = 0; m < 3; ++m) {
    Mesh mesh = meshOf(builder, "thing");
    for (int t = 0; t < 25; ++t) {
      const Vec3d middle = uniformPoint(next, 6 * size);
      for (int corner = 0; corner < 3; ++corner) {
        mesh.positions.push_back(Vec3f(middle + uniformPoint(next, 2 * size)));
      }
      const auto first = static_cast<std::uint32_t>(3 * t);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.surfaceOf.push_back(0);
    }
    const std::uint32_t index = builder.addMesh(std::move(mesh));
    for (int i = 0; i < 2; ++i) {
      const Mat3 turn =
          toMatrix(fromYawPitchRoll(uniform(next, -3, 3), uniform(next + 1, -1, 1), uniform(next + 2, -1, 1)));
      next += 3;
      const Mat3 stretch = Mat3::scale({i == 0 ? 1.0 : -0.7, 1.3, 0.9});
      const Vec3d offset = uniformPoint(next, 2 * size);
      const Vec3d exact{std::round(offset.x * 64) / 64, std::round(offset.y * 64) / 64, std::round(offset.z * 64) / 64};
      builder.place(index, {turn * stretch, where + exact}, "placed");
    }
  }
  return builder.finish();
}

// Pixels decided by less than this (px) may go either way: vertices lie on a grid of 1/256 px.
constexpr double kEdge = 0.01;

// Every pixel sees what the reference sees at its centre, or, where an edge is that near, around it.
inline void expectLikeReference(const Scene& scene, const Camera& camera, const DrawLimits& limits,
                                const PassPlanes& planes) {
  const RayReference reference(scene);
  std::vector<std::vector<ReferencePixel>> around;
  for (const auto& [dx, dy] :
       {std::pair{0., 0.}, {1., 0.}, {-1., 0.}, {0., 1.}, {0., -1.}, {.7, .7}, {-.7, .7}, {.7, -.7}, {-.7, -.7}}) {
    Camera moved = camera;
    moved.cx += dx * kEdge;
    moved.cy += dy * kEdge;
    around.push_back(reference.draw(moved, limits));
  }
  std::size_t clear = 0;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < camera.pixels(); ++i) {
    const auto matches = [&](const ReferencePixel& pixel) {
      if (pixel.instance == 0) return planes.depth[i] == kNoDepth;
      return planes.instance[i] == scene.instances[pixel.instance - 1].firstInstanceId &&
             planes.primitive[i] == pixel.triangle;
    };
    const ReferencePixel& middle = around.front()[i];
    const bool decided = std::all_of(around.begin(), around.end(), [&](const auto& image) {
      return image[i].instance == middle.instance && image[i].triangle == middle.triangle;
    });
    if (!decided) {
      wrong += std::none_of(around.begin(), around.end(), [&](const auto& image) { return matches(image[i]); });
      continue;
    }
    ++clear;
    if (!matches(middle)) {
      ++wrong;
    } else if (middle.instance != 0) {
      ASSERT_NEAR(planes.depth[i], middle.depth, 1e-7 * middle.depth) << "pixel " << i;
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(clear, camera.pixels() / 2);
}

}  // namespace scanmill
