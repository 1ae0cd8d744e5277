#include "methods/depth_camera/pixels.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr std::size_t kPixelGrain = 8192;

// Returns the nearest half-precision number, ties to even. Finite values beyond the largest one are clamped to it.
double asHalf(double value) {
  constexpr double kLargest = 65504;
  constexpr int kBits = 11;            // bits of the significand
  constexpr int kSmallestPower = -24;  // exponent of the spacing of subnormal numbers
  if (!std::isfinite(value)) return value;
  int power = 0;
  std::frexp(value, &power);
  const double step = std::ldexp(1.0, std::max(power - kBits, kSmallestPower));
  return std::clamp(std::nearbyint(value / step) * step, -kLargest, kLargest);
}

double asUnorm(double depth, int bits, double nearest, double farthest) {
  const double steps = std::ldexp(1.0, bits) - 1;
  const double clamped = std::clamp(depth, nearest, farthest);
  const double window = (1 / nearest - 1 / clamped) / (1 / nearest - 1 / farthest);
  const double stored = std::nearbyint(window * steps) / steps;
  return 1 / (1 / nearest - stored * (1 / nearest - 1 / farthest));
}

}  // namespace

float storedDepth(float depth, DepthFormat format, double nearest, double farthest) {
  constexpr double kShift = 500;  // m, added to coordinates by DepthFormat::Half500
  if (!(depth < kNoDepth)) return depth;
  switch (format) {
    case DepthFormat::Float32:
      break;
    case DepthFormat::Unorm24:
      return static_cast<float>(asUnorm(double{depth}, 24, nearest, farthest));
    case DepthFormat::Unorm16:
      return static_cast<float>(asUnorm(double{depth}, 16, nearest, farthest));
    case DepthFormat::Half500:
      return static_cast<float>(asHalf(double{depth} + kShift) - kShift);
  }
  return depth;
}

std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig,
                                std::uint32_t antialiasing) {
  std::vector<CameraView> views;
  const Mat3 rigFromWorld = transposed(toMatrix(worldFromRig.rotation));
  PixelAddress first = 0;
  for (const Camera& camera : cameras) {
    if (camera.width % antialiasing != 0 || camera.height % antialiasing != 0) {
      throw InputError(
          fmt::format("the image of camera '{}' has {} x {} pixels: with antialiasing {} both must be multiples of {}",
                      camera.name, camera.width, camera.height, antialiasing, antialiasing));
    }
    const Mat3 axes = rigFromWorld * toMatrix(camera.worldFromCamera.rotation);
    const double s = antialiasing;
    CameraView view;
    view.right = axes.x;
    view.down = axes.y;
    view.forward = axes.z;
    // Subtract before rotating: far from the world's origin this keeps a precision of micrometres.
    view.position = rigFromWorld * (camera.worldFromCamera.translation - worldFromRig.translation);
    view.fx = camera.fx / s;
    view.fy = camera.fy / s;
    view.cx = camera.cx / s;
    view.cy = camera.cy / s;
    view.width = camera.width / s;
    view.height = camera.height / s;
    view.lastU = std::nextafter(view.width, 0.0);
    view.lastV = std::nextafter(view.height, 0.0);
    view.rowLength = camera.width;
    view.first = first;
    views.push_back(view);
    first += static_cast<PixelAddress>(camera.pixels());
  }
  if (views.size() >= kNoView) throw InputError(fmt::format("a shot has {} images, which are too many", views.size()));
  return views;
}

void PixelReader::reset(std::size_t pixels) {
  pixels_ = pixels;
  addresses_.resize(pixels * options_.antialiasing * options_.antialiasing);
}

void PixelReader::aimAtNothing(std::size_t pixel) {
  for (std::size_t at = pixel; at < addresses_.size(); at += pixels_) addresses_[at] = kNoPixel;
}

void PixelReader::fetch() {
  PassPlanes& fetched = options_.antialiasing > 1 ? subpixels_ : planes_;
  source_.fetch(addresses_, choice_, fetched);
  const DepthFormat format = options_.depth;
  if (format == DepthFormat::Unorm24 || format == DepthFormat::Unorm16) {
    parallelFor(fetched.size(), kPixelGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        fetched.depth[i] = storedDepth(fetched.depth[i], format, options_.nearest, options_.farthest);
      }
    });
  }
  if (options_.antialiasing > 1) resolve();
}

void PixelReader::resolve() {
  planes_.reset(pixels_, choice_);
  const std::size_t s = options_.antialiasing;
  const std::size_t centre = (s / 2) * s + s / 2;
  const double share = 1.0 / static_cast<double>(s * s);
  parallelFor(pixels_, kPixelGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      double depth = 0;
      bool seen = false;
      for (std::size_t k = i; k < subpixels_.size(); k += pixels_) {
        const bool there = subpixels_.depth[k] < kNoDepth;
        seen = seen || there;
        depth += there ? double{subpixels_.depth[k]} : options_.farthest;
      }
      planes_.depth[i] = seen ? static_cast<float>(depth * share) : kNoDepth;
      const auto mean = [&](auto& to, const auto& from) {
        if (to.empty()) return;
        double sum = 0;
        for (std::size_t k = i; k < from.size(); k += pixels_) sum += double{from[k]};
        to[i] = static_cast<float>(sum * share);
      };
      mean(planes_.reflectance, subpixels_.reflectance);
      mean(planes_.roughness, subpixels_.roughness);
      mean(planes_.metallic, subpixels_.metallic);
      mean(planes_.retroreflectance, subpixels_.retroreflectance);
      if (!planes_.normal.empty()) {
        Vec3d sum;
        for (std::size_t k = i; k < subpixels_.size(); k += pixels_) sum += Vec3d(subpixels_.normal[k]);
        planes_.normal[i] = Vec3f(normalized(sum));
      }
      const auto pick = [&](auto& to, const auto& from) {
        if (!to.empty()) to[i] = from[centre * pixels_ + i];
      };
      forEachPass([&](const ChannelRow&, auto plane, auto) {
        using Of = typename std::remove_reference_t<decltype(planes_.*plane)>::value_type;
        if constexpr (std::is_integral_v<Of>) pick(planes_.*plane, subpixels_.*plane);
      });
    }
  });
}

}  // namespace scanmill
