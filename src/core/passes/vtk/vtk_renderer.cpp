// The VTK renderer: cameras become views, the plug-in draws them, and requested pixels become passes.
//
// An image has one number per pixel, the number of the visible triangle, and stays on the device. All other values,
// including the depth, are computed exactly from the number and the scene, and only for the pixels that are fetched.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>
#include <semaphore>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "gpu/device.h"
#include "passes/renderer.h"
#include "passes/resolver.h"
#include "passes/vtk/vtk_geometry.h"
#include "passes/vtk/vtk_interface.h"
#include "passes/vtk/vtk_view.h"

namespace scanmill {

namespace {

// Calls `work`, which uses the plug-in, and rethrows its exceptions as Error with a message about this renderer.
template <class Work>
decltype(auto) withErrorWords(const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw Error("images cannot be drawn, memory is out: take smaller images or a smaller scene");
  } catch (const NoDevice& e) {
    throw Error(
        fmt::format("images cannot be drawn, this machine has no OpenGL 4.3 by EGL ({}): {}, or take ray tracing",
                    e.what(), kInstallOpenGl));
  } catch (const std::exception& e) {
    throw Error(fmt::format("images cannot be drawn: {}", e.what()));
  }
}

// The plug-in's device, to which the constructor uploads the scene.
struct Device {
  explicit Device(const Scene& scene) : resolver(scene) {
    const auto& module = moduleOf<VtkModule>();
    withErrorWords([&] {
      plugin = module.open(namedDevice());
      geometry = buildViewGeometry(scene, plugin->limits().trianglesPerBatch);
      plugin->upload(geometry);
      plugin->finish();
    });
    for (ViewBatch* batch : {&geometry.solid, &geometry.cut}) {  // frees the other arrays
      *batch = {.positions = {},
                .uvs = {},
                .cutouts = {},
                .original = std::move(batch->original),
                .chunks = std::move(batch->chunks)};
    }
  }

  Resolver resolver;
  std::unique_ptr<VtkDevice> plugin;
  ViewGeometry geometry;  // geometry without the vertices, which are on the device
};

// Locks the renderer until its images are destroyed. This is a semaphore and not a mutex, because the images may be
// destroyed by another thread than the one that locked.
class RendererLock {
 public:
  explicit RendererLock(std::binary_semaphore& free) : free_(free) { free_.acquire(); }
  ~RendererLock() { free_.release(); }
  RendererLock(const RendererLock&) = delete;
  RendererLock& operator=(const RendererLock&) = delete;

 private:
  std::binary_semaphore& free_;
};

class VtkSource : public PixelSource {
 public:
  VtkSource(std::binary_semaphore& free, Device& device, const Scene& scene, std::vector<Camera> cameras,
            const DrawLimits& limits)
      : lock_(free), device_(device), cameras_(std::move(cameras)), firsts_(firstPixels(cameras_)) {
    views_.reserve(cameras_.size());
    for (std::uint32_t k = 0; k < cameras_.size(); ++k) {
      views_.emplace_back(scene, device_.geometry, cameras_[k], limits);
      withErrorWords([&] { device_.plugin->draw(k, views_.back().image()); });
    }
    withErrorWords([&] { device_.plugin->finish(); });
  }

  const std::vector<Camera>& cameras() const override { return cameras_; }
  PassChoice available() const override { return {Channels::all(), true}; }

  void fetch(std::span<const PixelAddress> addresses, PassChoice requested, PassPlanes& planes) override {
    constexpr std::size_t kGrain = 4096;  // pixels per task
    std::vector<VisibleTriangle> triangles(addresses.size());
    const std::vector<std::uint32_t> numbers = readNumbers(addresses);
    parallelFor(addresses.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (numbers[i] == 0) continue;
        const std::size_t image = imageOf(firsts_, addresses[i]);
        triangles[i] = views_[image].triangleAt(addresses[i] - firsts_[image], numbers[i]);
      }
    });
    device_.resolver.resolve(cameras_, addresses, triangles, requested, planes);
  }

 private:
  // Reads one triangle number per address from the device; 0 for kNoPixel.
  std::vector<std::uint32_t> readNumbers(std::span<const PixelAddress> addresses) {
    std::vector<std::uint32_t> numbers(addresses.size());
    VtkPixels pixels{};  // images after the last one are empty
    for (std::size_t k = 0; k < kVtkImages; ++k) {
      pixels.widths[k] = k < cameras_.size() ? cameras_[k].width : 1;
      pixels.firsts[k + 1] = firsts_[std::min(k + 1, cameras_.size())];
    }
    withErrorWords([&] { device_.plugin->gather(pixels, addresses, numbers.data()); });
    return numbers;
  }

  RendererLock lock_;
  Device& device_;
  std::vector<Camera> cameras_;
  std::vector<PixelAddress> firsts_;  // see firstPixels()
  std::vector<DrawnView> views_;
};

class VtkRenderer : public PassRenderer {
 public:
  explicit VtkRenderer(const Scene& scene) : scene_(scene), device_(scene) {}

  std::unique_ptr<PixelSource> draw(const std::vector<Camera>& cameras, const DrawLimits& limits, PassChoice) override {
    if (cameras.size() > kVtkImages) throw Error(fmt::format("at most {} images can be drawn at once", kVtkImages));
    const std::uint32_t largestSide = device_.plugin->limits().imageSize;  // px
    for (const Camera& camera : cameras) {
      if (camera.width <= largestSide && camera.height <= largestSide) continue;
      throw InputError(
          fmt::format("the camera '{}' has {} x {} pixels: an image is at most {} pixels wide and high here",
                      camera.name, camera.width, camera.height, largestSide));
    }
    return std::make_unique<VtkSource>(isFree_, device_, scene_, cameras, limits);
  }

  std::string device() const override { return device_.plugin->name(); }

 private:
  const Scene& scene_;
  Device device_;
  std::binary_semaphore isFree_{1};
};

}  // namespace

std::unique_ptr<PassRenderer> makeVtkRenderer(const Scene& scene) {
  return std::make_unique<VtkRenderer>(scene);
}

}  // namespace scanmill
