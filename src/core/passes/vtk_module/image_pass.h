#pragma once

// The render pass that renders an image of triangle numbers: each pixel gets the number of the triangle that is visible
// there.

#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkRenderPass.h>
#include <vtkTextureObject.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "gpu/opengl_module/gl_objects.h"
#include "passes/vtk/vtk_interface.h"

namespace scanmill {

// Locations of the vertex attributes; the shaders have the same numbers.
enum VertexAttribute : GLuint { kPosition = 0, kRows = 1, kFirstNumber = 4, kUv = 5, kCutout = 6 };
// Bindings of the shaders' storage buffers.
enum StorageBinding : GLuint { kCutouts = 0, kWords = 1 };

// The scene's triangles on the device.
class TriangleStore {
 public:
  explicit TriangleStore(const ViewGeometry& scene);

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

// Reads pixels of images back.
class GlPixelReader {
 public:
  GlPixelReader();

  // Implements VtkDevice::gather().
  void gather(const std::array<vtkTextureObject*, kVtkImages>& images, const VtkPixels& pixels,
              std::span<const std::uint32_t> addresses, std::uint32_t* numbers);

 private:
  GlProgram program_;
  GlBuffer addresses_;
  GlBuffer numbers_;
};

}  // namespace scanmill
