#pragma once

// Pinhole cameras, and the images that renderers return and EXR files store: passes, with one plane per channel.

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "scan/channels.h"
#include "scan/hits.h"

namespace scanmill {

// An ideal pinhole, without distortion. Camera axes, as OpenCV's: x right, y down, z forward (m). Pixel (column i, row
// j) covers [i, i + 1) x [j, j + 1) of the image plane, and its centre is at (i + 0.5, j + 0.5); row 0 is the top row.
//
//   u = cx + fx * x / z,  v = cy + fy * y / z
struct Camera {
  std::string name;  // a name such as "front", which becomes part of file names
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double fx = 0;  // px, focal lengths
  double fy = 0;
  double cx = 0;  // px, the principal point; may lie outside of the image
  double cy = 0;
  Pose worldFromCamera;

  std::size_t pixels() const { return std::size_t{width} * height; }
  // Return the angles (rad) between the outer edges of the image.
  double horizontalField() const { return std::atan((width - cx) / fx) + std::atan(cx / fx); }
  double verticalField() const { return std::atan((height - cy) / fy) + std::atan(cy / fy); }
  // Returns, in camera axes, the point at depth 1 m on the line of sight through the image position (u, v) (px).
  Vec3d ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1}; }
};

// Returns a camera with square pixels and its principal point in the image's centre. `horizontalField`: rad, below pi.
Camera squareCamera(std::uint32_t width, std::uint32_t height, double horizontalField);

// Returns the rotation from camera axes to x forward, y left, z up, for a camera that looks along the x axis.
inline Quat vehicleFromOptical() {
  return {0.5, -0.5, 0.5, -0.5};
}

// Depth of pixels that show no surface.
constexpr float kNoDepth = std::numeric_limits<float>::infinity();

// A choice of passes. In `channels`, Range stands for the depth, which is always included. Incidence has no pass of its
// own: it is computed from Normal.
struct PassChoice {
  Channels channels = Channel::Range;
  bool surfaceParameters = false;  // true: includes the material's roughness, metallic and retroreflectance

  bool operator==(const PassChoice&) const = default;
};

// Planes of n pixels as a structure of arrays; planes that were not requested are empty. A pixel that shows no surface
// has the depth kNoDepth, and zero in all other planes.
struct PassPlanes {
  std::vector<float> depth;              // m, planar: along the camera's z axis, not along the line of sight
  std::vector<Vec3f> normal;             // unit vectors, world axes, turned towards the camera
  std::vector<std::uint32_t> instance;   // instance id; 0: the surface belongs to no thing
  std::vector<std::uint16_t> semantic;   // class id
  std::vector<std::uint16_t> material;   // index into the scene's materials
  std::vector<std::uint32_t> primitive;  // index of the triangle in its mesh
  std::vector<float> reflectance;        // near-infrared, 0 to 1, with the texture applied
  std::vector<float> roughness;          // roughness, metallic and retroreflectance: all or none are present; see
                                         // scene/material.h
  std::vector<float> metallic;
  std::vector<float> retroreflectance;

  std::size_t size() const { return depth.size(); }
  PassChoice choice() const;
  // Resizes the planes that `requested` names and empties the other planes. The pixels' values are then undefined.
  void reset(std::size_t pixels, PassChoice requested);
};

// Calls visit(row of kChannels, pointer to member of PassPlanes, pointer to member of Hits) for each channel that
// renderers render. For the range, the member of PassPlanes is the depth.
template <class Visit>
constexpr void forEachPass(const Visit& visit) {
  visit(rowOf(Channel::Range), &PassPlanes::depth, &Hits::range);
  visit(rowOf(Channel::Normal), &PassPlanes::normal, &Hits::normal);
  visit(rowOf(Channel::Instance), &PassPlanes::instance, &Hits::instance);
  visit(rowOf(Channel::Semantic), &PassPlanes::semantic, &Hits::semantic);
  visit(rowOf(Channel::Material), &PassPlanes::material, &Hits::material);
  visit(rowOf(Channel::Primitive), &PassPlanes::primitive, &Hits::primitive);
  visit(rowOf(Channel::Reflectance), &PassPlanes::reflectance, &Hits::reflectance);
}
static_assert(
    [] {
      Channels visited;
      forEachPass([&](const ChannelRow& row, auto, auto) { visited |= row.channel; });
      return visited == channelsThat(&ChannelRow::rendered);
    }(),
    "visit every channel that renderers render, which passes/resolver.cpp and pass_picture.cpp then fill and show");

// One camera's image; planes are row by row from the top.
struct PassImage {
  Camera camera;
  PassPlanes planes;
};

// The number of a pixel in a set of images. All pixels of image 0 are counted, row by row, then all of image 1, etc.
using PixelAddress = std::uint32_t;
constexpr PixelAddress kNoPixel = 0xFFFFFFFFu;

// Returns the addresses of the images' first pixels, then the number of pixels. Throws InputError for too many pixels.
std::vector<PixelAddress> firstPixels(std::span<const Camera> cameras);

// Returns the index of the image that has a pixel. `firsts`: the result of firstPixels().
inline std::size_t imageOf(std::span<const PixelAddress> firsts, PixelAddress address) {
  std::size_t image = 0;
  while (image + 2 < firsts.size() && address >= firsts[image + 1]) ++image;
  return image;
}

// The images of one shot, either in memory or in a renderer. Not safe to call from several threads at once.
class PixelSource {
 public:
  virtual ~PixelSource() = default;
  virtual const std::vector<Camera>& cameras() const = 0;
  virtual PassChoice available() const = 0;  // passes that fetch() can fill
  // Fills `planes` with one entry per address; kNoPixel gives the values of a pixel that shows no surface. Throws
  // InputError if the images lack a requested pass.
  virtual void fetch(std::span<const PixelAddress> addresses, PassChoice requested, PassPlanes& planes) = 0;
};

// A source whose images are in memory. The images must outlive the source.
class ImageSource : public PixelSource {
 public:
  explicit ImageSource(std::span<const PassImage> images);
  const std::vector<Camera>& cameras() const override { return cameras_; }
  PassChoice available() const override { return available_; }
  void fetch(std::span<const PixelAddress> addresses, PassChoice requested, PassPlanes& planes) override;

 private:
  void require(PassChoice requested) const;

  std::span<const PassImage> images_;
  std::vector<Camera> cameras_;
  std::vector<PixelAddress> firsts_;  // see firstPixels()
  PassChoice available_;              // passes that all images have
};

// Returns a hint for messages about images without this pass: in brackets, what can be used instead. Returns an empty
// text if nothing can replace the pass.
std::string_view insteadOf(std::string_view pass);

// Returns all images of a source, with the requested passes.
std::vector<PassImage> readAll(PixelSource& source, PassChoice requested);

}  // namespace scanmill
