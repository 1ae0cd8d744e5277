#pragma once

// One camera's view of a scene: which chunks of which instances are drawn, and which triangle each number in the image
// stands for.

#include <cstdint>
#include <vector>

#include "passes/pass_image.h"
#include "passes/renderer.h"
#include "passes/resolver.h"
#include "passes/vtk/vtk_geometry.h"
#include "passes/vtk/vtk_interface.h"

namespace scanmill {

// A camera's view of a scene, drawn as an image whose pixels are the numbers of triangles. The scene and the geometry
// must outlive the view.
class DrawnView {
 public:
  DrawnView(const Scene& scene, const ViewGeometry& geometry, const Camera& camera, const DrawLimits& limits);

  // Returns the image to draw, which has pointers into this view.
  VtkImage image() const;
  // Returns the triangle that a pixel shows if the image's value there is `number`; none if `number` is 0 or the
  // triangle is beyond the far limit. The depth is that of the triangle's plane at the pixel's centre, in double,
  // clamped to the triangle's depths.
  SeenTriangle seen(std::uint32_t pixel, std::uint32_t number) const;

 private:
  // A visible instance of the scene, and the transform from the camera's frame to its mesh's frame.
  struct Frame {
    std::uint32_t instance;
    Mat3 meshFromCamera;
    Vec3d cameraInMesh;
    Vec3d depthAxis;  // depth = depthAxis . p + depthOffset, for points p in mesh axes
    double depthOffset;
  };
  struct Run {
    std::uint32_t firstTriangle;  // index within its batch
    std::uint32_t frame;
    bool cut;
  };
  struct Candidate;

  void addFrame(std::uint32_t instance, std::vector<Candidate>& solid, std::vector<Candidate>& cut);
  void addDraws(std::vector<Candidate>& candidates, bool cut, std::vector<VtkDraw>& draws);

  const Scene& scene_;
  const ViewGeometry& geometry_;
  Camera camera_;
  DrawLimits limits_;
  Mat3 cameraFromWorld_;
  std::vector<Frame> frames_;
  std::vector<VtkPlacement> rowsOfFrame_;
  std::vector<VtkPlacement> placements_;
  std::vector<VtkDraw> solid_;
  std::vector<VtkDraw> cut_;
  std::vector<Run> runs_;
  std::vector<std::uint32_t> firstNumbers_;  // number of each run's first triangle in the image, ascending
  std::uint64_t nextNumber_ = 1;
};

}  // namespace scanmill
