#pragma once

// Internals of the depth camera's sampling: reads the pixels into which beams fall, from images that may have
// subpixels.

#include <span>
#include <vector>

#include "methods/depth_camera/views.h"
#include "passes/pass_image.h"

namespace scanmill {

// Returns the images of a source, in the axes of the rig. Throws InputError if their sizes are no multiples of
// `antialiasing`, or if there are too many.
std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig,
                                std::uint32_t antialiasing);

// Fetches pixels and converts them to what a framebuffer with the antialiasing and the depth format of the options
// would have stored. Half500 is not applied here, since it rounds points, not depths.
class PixelReader {
 public:
  PixelReader(PixelSource& source, const SampleOptions& options, PassChoice choice)
      : source_(source), options_(options), choice_(choice) {}

  // After reset(), each pixel needs aim() or aimAtNothing() before fetch(). A pixel that is aimed at nothing gets the
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
  std::vector<PixelAddress> addresses_;  // subpixel by subpixel: subpixel * pixels + pixel
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
