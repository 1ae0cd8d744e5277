#pragma once

// The scene's triangles in buffers of OpenGL.

#include <span>

#include "gpu/opengl_module/gl_objects.h"
#include "passes/vtk/vtk_interface.h"

namespace scanmill {

// Locations of the vertex attributes; the shaders have the same numbers.
enum VertexAttribute : GLuint { kPosition = 0, kRows = 1, kFirstNumber = 4, kUv = 5, kCutout = 6 };
// Bindings of the shaders' storage buffers.
enum StorageBinding : GLuint { kCutouts = 0, kWords = 1 };

class TriangleStore {
 public:
  explicit TriangleStore(const VtkScene& scene);

  // Uploads the placements that the following calls of draw() use.
  void place(std::span<const VtkPlacement> placements);
  void draw(bool cut, std::span<const VtkDraw> draws);

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
