#pragma once

// Renders images of triangle numbers: each pixel gets the number of the triangle that is visible at the pixel.

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkTextureObject.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "gpu/opengl_module/gl_objects.h"
#include "passes/vtk/vtk_interface.h"

namespace scanmill {

// The scene's triangles on the device.
class TriangleStore {
 public:
  explicit TriangleStore(const ViewGeometry& scene);

  // Uploads the placements that the following calls of draw() use.
  void uploadPlacements(std::span<const VtkPlacement> placements);
  // Draws triangles of the solid batch or, if `cut` is true, of the batch with cut-outs, by the current program.
  void draw(bool cut, std::span<const VtkDraw> draws);

 private:
  GlBuffer solidPositions_;
  GlBuffer cutPositions_;
  GlBuffer cutUvs_;
  GlBuffer cutCutouts_;
  GlBuffer cutouts_;
  GlBuffer cutoutWords_;
  GlBuffer placements_;
  GlBuffer commands_;
  GlVertexArray solid_;
  GlVertexArray cut_;
};

// The context of `window` must be current at each call.
class ImagePass {
 public:
  // Renders an image of `triangles` into the texture of `slot`.
  void draw(vtkOpenGLRenderWindow* window, TriangleStore& triangles, const VtkImage& image, std::uint32_t slot);

  // Returns the texture of a slot, whose values are the numbers.
  vtkTextureObject* numbers(std::uint32_t slot) const { return slots_[slot]; }
  void releaseGraphicsResources(vtkOpenGLRenderWindow* window);

 private:
  void compilePrograms(vtkOpenGLRenderWindow* window);
  void prepareTextures(vtkOpenGLRenderWindow* window, const VtkImage& image, vtkTextureObject* numbers);

  bool zeroToOne_ = false;  // true if depths in clip space are from 0 to 1; set by compilePrograms()
  std::unique_ptr<GlProgram> solid_;
  std::unique_ptr<GlProgram> cut_;
  vtkNew<vtkOpenGLFramebufferObject> frame_;
  vtkNew<vtkTextureObject> depth_;
  std::array<vtkNew<vtkTextureObject>, kVtkImages> slots_;
};

}  // namespace scanmill
