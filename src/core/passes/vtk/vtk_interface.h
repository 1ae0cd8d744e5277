#pragma once

// The interface of the plug-in libscanmill_passes.so (base/module.h), which renders images of triangle numbers by VTK.

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/module.h"
#include "passes/vtk/vtk_geometry.h"

namespace scanmill {

constexpr std::uint32_t kVtkImages = 8;  // number of images that can be rendered and stored at the same time

struct VtkLimits {
  std::uint32_t imageSize = 0;          // px, largest width and height of an image
  std::uint64_t trianglesPerBatch = 0;  // largest number of triangles in a batch, so that one call can draw it
};

// An instance of the triangles of a VtkDraw. In the image, triangle k of the batch has the number firstNumber + k; the
// number 0 means that a pixel shows no triangle.
//
//   (x, y, w) of clip space = rows * (position, 1); the depth buffer contains nearest / w
struct VtkPlacement {
  float rows[3][4];
  std::uint32_t firstNumber;
};

// A draw call, which draws the triangles [firstTriangle, firstTriangle + triangles) once for each of the placements
// [firstPlacement, firstPlacement + placements).
struct VtkDraw {
  std::uint32_t firstTriangle;
  std::uint32_t triangles;
  std::uint32_t firstPlacement;
  std::uint32_t placements;
};

struct VtkImage {
  std::uint32_t width = 0;   // px, width of the image
  std::uint32_t height = 0;  // px, height of the image
  float nearest = 0;         // m, depth of the near clipping plane w = nearest
  std::span<const VtkPlacement> placements;
  std::span<const VtkDraw> solid;  // in drawing order: of triangles at equal depth, the first one is visible
  std::span<const VtkDraw> cut;
};

// Defines the addresses of pixels, which number all pixels row by row, from the image of slot 0 to the image of slot 7.
struct VtkPixels {
  std::uint32_t firsts[kVtkImages + 1];  // address of each image's first pixel; last entry: number of all pixels
  std::uint32_t widths[kVtkImages];      // px, width of each image
};

// A device that renders a scene. Calls may come from any thread, but only one at a time. Calls throw std::bad_alloc if
// memory is exhausted, and std::runtime_error for other errors.
class VtkDevice {
 public:
  virtual ~VtkDevice() = default;
  virtual std::string name() const = 0;  // "VTK 9.1 on llvmpipe (LLVM 15.0.6, 256 bits)"
  virtual VtkLimits limits() const = 0;
  virtual void upload(const ViewGeometry& scene) = 0;
  // Renders an image into `slot` (0 to 7) and replaces the slot's previous image. Row 0 is the top row.
  virtual void draw(std::uint32_t slot, const VtkImage& image) = 0;
  // Waits until all requested work is done.
  virtual void finish() = 0;
  // Reads the triangle numbers at pixel addresses. An address must be in a rendered image or beyond all images; beyond
  // all images, the number is 0.
  virtual void gather(const VtkPixels& pixels, std::span<const std::uint32_t> addresses, std::uint32_t* numbers) = 0;
};

class VtkModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_passes.so", "images cannot be drawn by VTK",
                                    "install VTK and EGL (on Debian the packages libvtk9-dev and libegl-dev)"};
  virtual ~VtkModule() = default;
  // Opens a device. `device`: a name as namedDevice() returns it (gpu/device.h). Throws NoDevice if no device is
  // suitable, and std::invalid_argument if no device has that name.
  virtual std::unique_ptr<VtkDevice> open(const std::string& device) const = 0;
};

}  // namespace scanmill
