#pragma once

// Internal to the depth camera: reads the pixels that beams fall into. The images may have subpixels, which are then
// averaged.

#include <span>
#include <vector>

#include "methods/depth_camera/views.h"
#include "passes/pass_image.h"

namespace scanmill {

// Returns the images of a source, in rig axes. Throws InputError if there are too many images, or if their sizes are
// not multiples of `antialiasing`.
std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig,
                                std::uint32_t antialiasing);

// Fetches pixels and converts them as a framebuffer with the antialiasing and the depth format of the options would.
// Half500 is not applied here, because it rounds points and not depths.
class PixelReader {
 public:
  PixelReader(PixelSource& source, const SampleOptions& options, PassChoice choice)
      : source_(source), options_(options), choice_(choice) {}

  // Between reset() and fetch(), each pixel needs a call of aim() or aimAtNothing(). aimAtNothing() gives a pixel the
  // address kNoPixel.
  void reset(std::size_t pixels);
  void aim(std::size_t pixel, const CameraView& view, double column, double row);
  void aimAtNothing(std::size_t pixel);
  void fetch();
  const PassPlanes& planes() const { return planes_; }

 private:
  void resolve();

  PixelSource& source_;
  SampleOptions options_;
  PassChoice choice_;
  std::size_t pixels_ = 0;
  std::vector<PixelAddress> addresses_;  // index: subpixel * pixels + pixel
  PassPlanes subpixels_;
  PassPlanes planes_;
};

inline void PixelReader::aim(std::size_t pixel, const CameraView& view, double column, double row) {
  const std::uint32_t s = options_.antialiasing;
  const auto x = static_cast<std::uint32_t>(static_cast<std::int32_t>(column)) * s;
  const auto y = static_cast<std::uint32_t>(static_cast<std::int32_t>(row)) * s;
  for (std::uint32_t j = 0; j < s; ++j) {
    for (std::uint32_t i = 0; i < s; ++i) {
      addresses_[(j * s + i) * pixels_ + pixel] = view.first + (y + j) * view.rowLength + x + i;
    }
  }
}

}  // namespace scanmill
