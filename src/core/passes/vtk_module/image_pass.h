#pragma once

// The render pass that renders an image of triangle numbers: each pixel gets the number of the triangle that is visible
// there.

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkRenderPass.h>
#include <vtkTextureObject.h>

#include <array>
#include <memory>
#include <string>

#include "gpu/opengl_module/gl_objects.h"
#include "passes/vtk/vtk_interface.h"
#include "passes/vtk_module/triangle_store.h"

namespace scanmill {

class ImagePass : public vtkRenderPass {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts references
 public:
  static ImagePass* New();

  // Sets the triangles and the image that the next Render() draws, and the slot that it draws into.
  void next(TriangleStore* triangles, const VtkImage* image, std::uint32_t slot);
  void Render(const vtkRenderState* state) override;

  vtkTextureObject* numbers(std::uint32_t slot) const { return slots_[slot]; }
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  ImagePass() = default;
  ~ImagePass() override = default;

 private:
  void prepare(vtkOpenGLRenderWindow* window);
  void draw(vtkOpenGLRenderWindow* window);

  TriangleStore* triangles_ = nullptr;
  const VtkImage* image_ = nullptr;
  std::uint32_t slot_ = 0;
  bool zeroToOne_ = false;  // true if depths in clip space are from 0 to 1

  std::unique_ptr<GlProgram> solid_;
  std::unique_ptr<GlProgram> cut_;
  vtkNew<vtkOpenGLFramebufferObject> frame_;
  vtkNew<vtkTextureObject> depth_;
  std::array<vtkNew<vtkTextureObject>, kVtkImages> slots_;
};

}  // namespace scanmill
