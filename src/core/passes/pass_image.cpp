#include "passes/pass_image.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr std::size_t kImageGrain = 8192;  // pixels per task

// Calls visit(pointer to member) for each plane of PassPlanes.
template <class Visit>
void forEachPlane(const Visit& visit) {
  forEachPass([&](const ChannelRow&, auto plane, auto) { visit(plane); });
  visit(&PassPlanes::roughness);
  visit(&PassPlanes::metallic);
  visit(&PassPlanes::retroreflectance);
}

}  // namespace

PassChoice PassPlanes::choice() const {
  PassChoice present;
  forEachPass([&](const ChannelRow& row, auto plane, auto) {
    if (!(this->*plane).empty()) present.channels |= row.channel;
  });
  present.surfaceParameters = !roughness.empty() && !metallic.empty() && !retroreflectance.empty();
  return present;
}

void PassPlanes::reset(std::size_t pixels, PassChoice requested) {
  requested.channels |= Channel::Range;
  forEachPass([&](const ChannelRow& row, auto plane, auto) {
    (this->*plane).resize(requested.channels.has(row.channel) ? pixels : 0);
  });
  for (auto* plane : {&roughness, &metallic, &retroreflectance})
    plane->resize(requested.surfaceParameters ? pixels : 0);
}

std::vector<PixelAddress> firstPixels(std::span<const Camera> cameras) {
  std::vector<PixelAddress> firsts{0};
  std::size_t pixels = 0;
  for (const Camera& camera : cameras) {
    pixels += camera.pixels();
    firsts.push_back(static_cast<PixelAddress>(pixels));
  }
  if (pixels < kNoPixel) return firsts;
  throw InputError(fmt::format("{} pixels in a shot's images are too many: take smaller ones", pixels));
}

ImageSource::ImageSource(std::span<const PassImage> images) : images_(images), available_{Channels::all(), true} {
  for (const PassImage& image : images) {
    cameras_.push_back(image.camera);
    const PassChoice available = image.planes.choice();
    available_.channels = available_.channels & available.channels;
    available_.surfaceParameters = available_.surfaceParameters && available.surfaceParameters;
  }
  firsts_ = firstPixels(cameras_);
}

// Throws InputError if an image lacks a requested pass. The message names the first such image.
void ImageSource::require(PassChoice requested) const {
  for (const PassImage& image : images_) {
    const PassChoice available = image.planes.choice();
    for (const ChannelRow& row : kChannels) {
      const bool isNeeded = row.channel != Channel::Range && row.rendered && requested.channels.has(row.channel);
      if (!isNeeded || available.channels.has(row.channel)) continue;  // all images have the range
      // The hint to add the surface parameters instead of the material is left out if the image has these parameters.
      const bool hasSubstitute = row.channel == Channel::Material && available.surfaceParameters;
      throw InputError(fmt::format("the image of camera '{}' has no pass '{}', which the pipeline needs{}",
                                   image.camera.name, row.name, hasSubstitute ? "" : insteadOf(row.name)));
    }
    if (requested.surfaceParameters && !available.surfaceParameters) {
      throw InputError(
          fmt::format("the image of camera '{}' has no passes roughness, metallic and retroreflectance, "
                      "which the pipeline needs",
                      image.camera.name));
    }
  }
}

// Copies plane by plane within each block of addresses: the loads of a loop over one plane do not depend on each other,
// so that the CPU overlaps their cache misses.
void ImageSource::fetch(std::span<const PixelAddress> addresses, PassChoice requested, PassPlanes& planes) {
  require(requested);
  planes.reset(addresses.size(), requested);
  parallelFor(addresses.size(), kImageGrain, [&](std::size_t first, std::size_t end) {
    struct PixelPosition {
      std::size_t image;   // index into images_
      PixelAddress pixel;  // index in the image's planes; kNoPixel: no pixel
    };
    constexpr std::size_t kBlock = 1024;  // addresses whose positions are computed before their pixels are copied
    PixelPosition positions[kBlock];
    for (; first < end; first += std::min(kBlock, end - first)) {
      const std::size_t count = std::min(kBlock, end - first);
      for (std::size_t i = 0; i < count; ++i) {
        const PixelAddress address = addresses[first + i];
        const std::size_t image = imageOf(firsts_, address);
        positions[i] = {image, address == kNoPixel ? kNoPixel : address - firsts_[image]};
      }
      forEachPlane([&]<class T>(std::vector<T> PassPlanes::*plane) {
        std::vector<T>& copies = planes.*plane;
        if (copies.empty()) return;
        T background{};
        if constexpr (std::is_same_v<T, float>) background = plane == &PassPlanes::depth ? kNoDepth : 0;
        for (std::size_t i = 0; i < count; ++i) {
          const auto [image, pixel] = positions[i];
          copies[first + i] = pixel == kNoPixel ? background : (images_[image].planes.*plane)[pixel];
        }
      });
    }
  });
}

std::string_view insteadOf(std::string_view pass) {
  if (pass == "material") return " (roughness, metallic and retroreflectance in its place will do)";
  if (pass == "normal") return " (`sampling: nearest` does without, if nothing else needs them)";
  return "";
}

std::vector<PassImage> readAll(PixelSource& source, PassChoice requested) {
  std::vector<PassImage> images;
  PixelAddress firstPixel = 0;
  std::vector<PixelAddress> addresses;
  for (const Camera& camera : source.cameras()) {
    addresses.resize(camera.pixels());
    std::iota(addresses.begin(), addresses.end(), firstPixel);
    firstPixel += static_cast<PixelAddress>(addresses.size());
    PassImage image{camera, {}};
    source.fetch(addresses, requested, image.planes);
    images.push_back(std::move(image));
  }
  return images;
}

Camera squareCamera(std::uint32_t width, std::uint32_t height, double horizontalField) {
  const double focal = width / (2 * std::tan(horizontalField / 2));  // px
  return {.name = {},
          .width = width,
          .height = height,
          .fx = focal,
          .fy = focal,
          .cx = width / 2.0,
          .cy = height / 2.0,
          .worldFromCamera = {}};
}

}  // namespace scanmill
