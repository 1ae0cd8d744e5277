#include "passes/pass_image.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr std::size_t kImageGrain = 8192;  // pixels per task

// Calls use(member) for each plane of PassPlanes, as a pointer to member.
template <class Use>
void forPlanes(const Use& use) {
  forEachPass([&](const ChannelRow&, auto plane, auto) { use(plane); });
  use(&PassPlanes::roughness);
  use(&PassPlanes::metallic);
  use(&PassPlanes::retroreflectance);
}

}  // namespace

PassChoice PassPlanes::choice() const {
  PassChoice made;
  forEachPass([&](const ChannelRow& row, auto plane, auto) {
    if (!(this->*plane).empty()) made.channels |= row.channel;
  });
  made.surfaceParameters = !roughness.empty() && !metallic.empty() && !retroreflectance.empty();
  return made;
}

void PassPlanes::reset(std::size_t pixels, PassChoice asked) {
  asked.channels |= Channel::Range;
  forEachPass([&](const ChannelRow& row, auto plane, auto) {
    (this->*plane).resize(asked.channels.has(row.channel) ? pixels : 0);
  });
  for (auto* plane : {&roughness, &metallic, &retroreflectance}) plane->resize(asked.surfaceParameters ? pixels : 0);
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

void ImageSource::require(PassChoice asked) const {
  for (const PassImage& image : images_) {
    const PassChoice available = image.planes.choice();
    for (const ChannelRow& row : kChannels) {
      if (row.channel == Channel::Range || !row.rendered || !asked.channels.has(row.channel) ||
          available.channels.has(row.channel)) {
        continue;
      }
      const bool hasSubstitute = row.channel == Channel::Material && available.surfaceParameters;
      throw InputError(fmt::format("the image of camera '{}' has no pass '{}', which the pipeline needs{}",
                                   image.camera.name, row.name, hasSubstitute ? "" : insteadOf(row.name)));
    }
    if (asked.surfaceParameters && !available.surfaceParameters) {
      throw InputError(
          fmt::format("the image of camera '{}' has no passes roughness, metallic and retroreflectance, "
                      "which the pipeline needs",
                      image.camera.name));
    }
  }
}

// Copies one plane after the other, so that the memory accesses for the pixels of a plane overlap.
void ImageSource::fetch(std::span<const PixelAddress> addresses, PassChoice asked, PassPlanes& planes) {
  require(asked);
  planes.reset(addresses.size(), asked);
  parallelFor(addresses.size(), kImageGrain, [&](std::size_t first, std::size_t last) {
    struct Place {
      std::size_t image;
      PixelAddress pixel;
    };
    constexpr std::size_t kBlock = 1024;
    Place places[kBlock];
    for (; first < last; first += std::min(kBlock, last - first)) {
      const std::size_t count = std::min(kBlock, last - first);
      for (std::size_t i = 0; i < count; ++i) {
        const PixelAddress address = addresses[first + i];
        const std::size_t image = imageOf(firsts_, address);
        places[i] = {image, address == kNoPixel ? kNoPixel : address - firsts_[image]};
      }
      forPlanes([&](auto plane) {
        auto& to = planes.*plane;
        using PlaneValue = typename std::remove_reference_t<decltype(to)>::value_type;
        if (to.empty()) return;
        PlaneValue nothing{};
        if constexpr (std::is_same_v<decltype(plane), decltype(&PassPlanes::depth)>) {
          if (plane == &PassPlanes::depth) nothing = kNoDepth;
        }
        for (std::size_t i = 0; i < count; ++i) {
          const auto [image, pixel] = places[i];
          to[first + i] = pixel == kNoPixel ? nothing : (images_[image].planes.*plane)[pixel];
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

std::vector<PassImage> readAll(PixelSource& source, PassChoice asked) {
  std::vector<PassImage> images;
  PixelAddress next = 0;
  std::vector<PixelAddress> addresses;
  for (const Camera& camera : source.cameras()) {
    addresses.resize(camera.pixels());
    for (PixelAddress& address : addresses) address = next++;
    PassImage image{camera, {}};
    source.fetch(addresses, asked, image.planes);
    images.push_back(std::move(image));
  }
  return images;
}

double Camera::horizontalField() const {
  return std::atan((width - cx) / fx) + std::atan(cx / fx);
}

double Camera::verticalField() const {
  return std::atan((height - cy) / fy) + std::atan(cy / fy);
}

Camera squareCamera(std::uint32_t width, std::uint32_t height, double horizontalField) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = width / (2 * std::tan(horizontalField / 2));
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

Quat vehicleFromOptical() {
  return {0.5, -0.5, 0.5, -0.5};
}

}  // namespace scanmill
