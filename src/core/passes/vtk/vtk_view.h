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
  // Returns the triangle that a pixel (its index in the image) shows if the image's value at the pixel is `number`;
  // none if `number` is 0 or the triangle is beyond the far limit. The depth is the depth of the triangle's plane at
  // the pixel's centre, computed in double and clamped to the depths of the triangle's corners.
  VisibleTriangle triangleAt(std::uint32_t pixel, std::uint32_t number) const;

 private:
  // A visible instance of the scene, and the transform from the camera's frame to its mesh's frame.
  struct Frame {
    std::uint32_t instance;
    Mat3 meshFromCamera;
    Vec3d cameraInMesh;
    Vec3d depthAxis;  // depth = depthAxis . p + depthOffset, for points p in mesh axes
    double depthOffset;
    VtkPlacement placement;  // without the number
  };
  // A chunk that is drawn for one instance: its triangles have consecutive numbers in the image.
  struct DrawnChunk {
    std::uint32_t firstTriangle;  // index within `batch`
    std::uint32_t frame;          // index into frames_
    const ViewBatch* batch;
  };
  struct Candidate;

  void addFrame(std::uint32_t instance, std::vector<Candidate>& solid, std::vector<Candidate>& cut);
  void addDraws(std::vector<Candidate>& candidates, const ViewBatch& batch, std::vector<VtkDraw>& draws);

  const Scene& scene_;
  const ViewGeometry& geometry_;
  Camera camera_;
  DrawLimits limits_;
  Mat3 cameraFromWorld_;
  std::vector<Frame> frames_;
  std::vector<VtkPlacement> placements_;  // by drawn chunk
  std::vector<VtkDraw> solid_;
  std::vector<VtkDraw> cut_;
  std::vector<DrawnChunk> drawnChunks_;
  std::vector<std::uint32_t> firstNumbers_;  // by drawn chunk: number of its first triangle in the image, ascending
  std::uint64_t nextNumber_ = 1;
};

}  // namespace scanmill
