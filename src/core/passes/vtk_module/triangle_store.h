#pragma once

// The scene's triangles where OpenGL draws from.

#include "passes/vtk/vtk_module.h"
#include "passes/vtk_module/gl_objects.h"

namespace scanmill {

// Locations of the vertex attributes, in the shaders too.
enum VertexAttribute : GLuint { kPosition = 0, kRows = 1, kFirstNumber = 4, kUv = 5, kCutout = 6 };
// Bindings of the storage buffers.
enum StorageBinding : GLuint { kCutouts = 0, kWords = 1 };

class TriangleStore {
 public:
  explicit TriangleStore(const ScanmillVtkScene& scene);

  // The placings that the following draws name.
  void place(const ScanmillVtkPlacement* placements, std::size_t count);
  void draw(bool cut, const ScanmillVtkDraw* draws, std::size_t count);

 private:
  GlBuffer solidPositions_;
  GlBuffer cutPositions_;
  GlBuffer cutUvs_;
  GlBuffer cutCutouts_;
  GlBuffer cutouts_;
  GlBuffer words_;
  GlBuffer placements_;
  GlBuffer commands_;
  GlVertexArray solid_;
  GlVertexArray cut_;
};

}  // namespace scanmill
