#pragma once

// Reads pixels back from the card: single pixels, which a compute shader gathers so that only these are transferred, or
// complete rows.

#include <vtkTextureObject.h>

#include <array>
#include <cstdint>
#include <span>

#include "gpu/opengl_module/gl_objects.h"
#include "passes/vtk/vtk_interface.h"

namespace scanmill {

class GlPixelReader {
 public:
  GlPixelReader();
  ~GlPixelReader();
  GlPixelReader(const GlPixelReader&) = delete;
  GlPixelReader& operator=(const GlPixelReader&) = delete;

  // Implement VtkDevice::gather() and VtkDevice::read().
  void gather(const std::array<vtkTextureObject*, kVtkImages>& images, const VtkPixels& pixels,
              std::span<const std::uint32_t> addresses, std::uint32_t* numbers);
  void read(vtkTextureObject* image, std::uint32_t firstRow, std::uint32_t rows, std::uint32_t* numbers);

 private:
  GlProgram program_;
  GlBuffer addresses_;
  GlBuffer numbers_;
  GLuint frame_ = 0;
};

}  // namespace scanmill
