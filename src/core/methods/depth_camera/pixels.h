#pragma once

// Inside of the depth camera's sampling: reads the pixels that beams fall into, from images that may be finer.

#include <span>
#include <vector>

#include "methods/depth_camera/views.h"
#include "passes/pass_image.h"

namespace scanmill {

// The images of a source in the axes of the rig. Throws InputError where they cannot be resolved.
std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig,
                                std::uint32_t antialiasing);

// Fetches pixels and turns them into what a framebuffer with the antialiasing and the depth format of the options would
// have kept. Half500 is not applied here: it rounds points, not depths.
class PixelReader {
 public:
  PixelReader(PixelSource& source, const SampleOptions& options, PassChoice choice)
      : source_(source), options_(options), choice_(choice) {}

  // Addresses of a pixel's subpixels are set by aim(); a pixel that nobody aimed at is kNoPixel.
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
