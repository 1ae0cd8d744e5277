// The VTK renderer: cameras become views, the plug-in draws them, and requested pixels become passes.
//
// An image has one number per pixel, the number of the visible triangle, and stays on the device. All other values,
// including the depth, are computed exactly from the number and the scene, and only for the pixels that are fetched.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
#include "scene/triangles.h"

namespace scanmill {

namespace {

// A chunk that may be visible.
struct Candidate {
  int distance;  // distance from the camera in logarithmic steps: 4 log2(1 + distance in m)
  std::uint32_t chunk;
  std::uint32_t frame;

  auto operator<=>(const Candidate&) const = default;
};

// A half-space. A point p is inside if normal . p + offset >= 0.
struct HalfSpace {
  Vec3d normal;
  double offset;
};

enum class Side { Outside, Across, Inside };

// Returns Outside if the box from `low` to `high` is outside of a space, Inside if it is in all six, otherwise Across.
Side sideOf(const std::array<HalfSpace, 6>& spaces, const Vec3f& low, const Vec3f& high) {
  const Vec3d center = (Vec3d(low) + Vec3d(high)) * 0.5;
  const Vec3d half = (Vec3d(high) - Vec3d(low)) * 0.5;
  Side side = Side::Inside;
  for (const HalfSpace& space : spaces) {
    const double middle = dot(space.normal, center) + space.offset;
    const double reach =
        std::abs(space.normal.x) * half.x + std::abs(space.normal.y) * half.y + std::abs(space.normal.z) * half.z;
    const double slack = 1e-6 * (std::abs(middle) + reach);  // tolerance for the rounding of boxes that touch the plane
    if (middle + reach < -slack) return Side::Outside;
    if (middle - reach < slack) side = Side::Across;
  }
  return side;
}

// A transform of mesh points to the camera's axes (m). `rows.x` is the first row of its matrix, and so on.
struct CameraFromMesh {
  Mat3 rows;
  Vec3d translation;

  // Returns the half-space of mesh points p that have x * px + y * py + z * pz >= 0 in the camera's axes.
  HalfSpace combine(double x, double y, double z) const {
    return {rows.x * x + rows.y * y + rows.z * z, x * translation.x + y * translation.y + z * translation.z};
  }
};

// Returns the half-spaces of mesh points that bound the camera's view: left, right, upper, lower, near and far.
std::array<HalfSpace, 6> viewVolume(const CameraFromMesh& map, const Camera& camera, const DrawLimits& limits) {
  return {map.combine(camera.fx, 0, camera.cx),
          map.combine(-camera.fx, 0, camera.width - camera.cx),
          map.combine(0, camera.fy, camera.cy),
          map.combine(0, -camera.fy, camera.height - camera.cy),
          HalfSpace{map.rows.z, map.translation.z - limits.nearest},
          HalfSpace{-map.rows.z, limits.farthest - map.translation.z}};
}

// Returns a placement, still without firstNumber, whose rows transform mesh points to clip coordinates x, y, w = depth.
VtkPlacement placementOf(const CameraFromMesh& map, const Camera& camera) {
  const HalfSpace clip[3] = {map.combine(2 * camera.fx / camera.width, 0, 2 * camera.cx / camera.width - 1),
                             map.combine(0, 2 * camera.fy / camera.height, 2 * camera.cy / camera.height - 1),
                             map.combine(0, 0, 1)};
  VtkPlacement placement{};
  for (std::size_t row = 0; row < 3; ++row) {
    const auto& [normal, offset] = clip[row];
    const std::array<double, 4> values{normal.x, normal.y, normal.z, offset};
    for (std::size_t k = 0; k < 4; ++k) placement.rows[row][k] = static_cast<float>(values[k]);
  }
  return placement;
}

// Returns a lower bound of the distance (m) from the camera to a box in mesh axes: the distance to an enclosing box
// that is aligned with the camera's axes.
double leastDistance(const CameraFromMesh& map, const Vec3f& low, const Vec3f& high) {
  constexpr double kRoundUp = 1 + 1e-9;  // so that rounding leaves out no box
  const Vec3d middle = (Vec3d(low) + Vec3d(high)) * 0.5;
  const Vec3d half = (Vec3d(high) - Vec3d(low)) * 0.5;
  const auto gap = [&](const Vec3d& row, double translation) {
    const double reach = std::abs(row.x) * half.x + std::abs(row.y) * half.y + std::abs(row.z) * half.z;
    return std::max(std::abs(dot(row, middle) + translation) - reach * kRoundUp, 0.0);
  };
  return length(Vec3d{gap(map.rows.x, map.translation.x), gap(map.rows.y, map.translation.y),
                      gap(map.rows.z, map.translation.z)});
}

// A camera's view of a scene, drawn as an image of triangle numbers. Scene and geometry must outlive the view.
class DrawnView {
 public:
  DrawnView(const Scene& scene, const ViewGeometry& geometry, const Camera& camera, const DrawLimits& limits)
      : scene_(scene),
        geometry_(geometry),
        camera_(camera),
        limits_(limits),
        cameraFromWorld_(transposed(toMatrix(camera.worldFromCamera.rotation))) {
    std::vector<Candidate> solid;
    std::vector<Candidate> cut;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) addFrame(i, solid, cut);
    addDraws(solid, geometry.solid, solid_);
    addDraws(cut, geometry.cut, cut_);
  }

  // Returns the image to draw. The image's arrays belong to this view.
  VtkImage image() const {
    return {camera_.width, camera_.height, static_cast<float>(limits_.nearest), placements_, solid_, cut_};
  }

  // Returns the triangle that pixel `pixel` of the image shows if the pixel's value is `number`; none if `number` is 0
  // or the triangle is beyond the far limit. The depth is the depth of the triangle's plane at the pixel's centre,
  // computed in double and clamped to the depths of the triangle's corners.
  VisibleTriangle triangleAt(std::uint32_t pixel, std::uint32_t number) const {
    if (number == 0) return {};
    const auto nextChunk = std::ranges::upper_bound(firstNumbers_, number);
    const auto index = static_cast<std::size_t>(nextChunk - firstNumbers_.begin() - 1);
    const DrawnChunk& chunk = drawnChunks_[index];
    const Frame& frame = frames_[chunk.frame];
    const Mesh& mesh = scene_.meshes[scene_.instances[frame.instance].mesh];
    const std::uint32_t triangle = chunk.batch->original[chunk.firstTriangle + (number - firstNumbers_[index])];

    const auto [a, b, c] = cornersOf(mesh, triangle);
    const Vec3d normal = cross(b - a, c - a);
    const Vec3d ray = camera_.ray(pixel % camera_.width + 0.5, pixel / camera_.width + 0.5);
    const double depth = dot(normal, a - frame.cameraInMesh) / dot(normal, frame.meshFromCamera * ray);
    // If a triangle is seen edge-on, the line of sight may intersect its plane outside of the triangle, or not at all.
    // Clamp the depth to the depths of the corners.
    const auto depthOf = [&](const Vec3d& p) { return dot(frame.depthAxis, p) + frame.depthOffset; };
    const auto [least, most] = std::minmax({depthOf(a), depthOf(b), depthOf(c)});
    const double nearest = std::max(least, limits_.nearest);
    const double clamped = depth >= nearest ? std::min(depth, std::max(most, nearest)) : nearest;  // `nearest` if NaN
    if (clamped > limits_.farthest) return {};
    return {static_cast<float>(clamped), frame.instance + 1, triangle};
  }

 private:
  // A visible instance of the scene, and the transform from the camera's frame to the frame of the instance's mesh.
  struct Frame {
    std::uint32_t instance;
    Mat3 meshFromCamera;
    Vec3d cameraInMesh;
    Vec3d depthAxis;  // depth = depthAxis . p + depthOffset, for points p in mesh axes
    double depthOffset;
    VtkPlacement placement;  // without firstNumber
  };
  // A chunk that is drawn for one instance: its triangles have consecutive numbers in the image.
  struct DrawnChunk {
    std::uint32_t firstTriangle;  // index in `batch`
    std::uint32_t frame;          // index into frames_
    const ViewBatch* batch;
  };

  // Adds an instance to frames_, and its chunks to the candidates, if it may be visible. Computes in double precision
  // from the instance's position relative to the camera, so that the precision is the same far from the world's origin.
  void addFrame(std::uint32_t index, std::vector<Candidate>& solid, std::vector<Candidate>& cut) {
    const Instance& instance = scene_.instances[index];
    const ViewMesh& mesh = geometry_.meshes[instance.mesh];
    const Affine& worldFromMesh = instance.worldFromMesh;
    const Vec3d offset = worldFromMesh.translation - camera_.worldFromCamera.translation;
    const Mat3 linear = cameraFromWorld_ * worldFromMesh.linear;
    // `map` transforms points relative to mesh.origin, as the bounds of the mesh and its chunks are.
    const CameraFromMesh map{transposed(linear), cameraFromWorld_ * offset + linear * mesh.origin};
    const std::array<HalfSpace, 6> volume = viewVolume(map, camera_, limits_);
    const Side side = sideOf(volume, mesh.low, mesh.high);
    const auto isOutOfReach = [&](const Vec3f& low, const Vec3f& high) {
      return leastDistance(map, low, high) > limits_.reach;
    };
    if (side == Side::Outside || isOutOfReach(mesh.low, mesh.high)) return;

    const Mat3 meshFromWorld = inverse(worldFromMesh.linear);
    const Vec3d cameraInMesh = -(meshFromWorld * offset);
    const double scale = std::cbrt(std::abs(determinant(worldFromMesh.linear)));  // m in the world per m in the mesh
    const auto frame = static_cast<std::uint32_t>(frames_.size());
    const auto addVisible = [&](const ViewBatch& batch, const ChunkRange& range, std::vector<Candidate>& candidates) {
      for (std::uint32_t c = range.first; c < range.end; ++c) {
        const ViewChunk& chunk = batch.chunks[c];
        if (side == Side::Across && sideOf(volume, chunk.low, chunk.high) == Side::Outside) continue;
        if (isOutOfReach(chunk.low, chunk.high)) continue;
        const double distance = scale * Box{Vec3d(chunk.low), Vec3d(chunk.high)}.distanceTo(cameraInMesh - mesh.origin);
        candidates.push_back({static_cast<int>(4 * std::log2(1 + distance)), c, frame});
      }
    };
    addVisible(geometry_.solid, mesh.solid, solid);
    addVisible(geometry_.cut, mesh.cut, cut);

    frames_.push_back({.instance = index,
                       .meshFromCamera = meshFromWorld * transposed(cameraFromWorld_),
                       .cameraInMesh = cameraInMesh,
                       .depthAxis = map.rows.z,
                       .depthOffset = map.translation.z - dot(map.rows.z, mesh.origin),
                       .placement = placementOf(map, camera_)});
  }

  // Appends draw calls of the visible chunks, all of one batch. Near chunks are drawn first, so that they hide farther
  // ones. Instances of the same chunk at the same distance step are drawn by one call.
  void addDraws(std::vector<Candidate>& candidates, const ViewBatch& batch, std::vector<VtkDraw>& draws) {
    std::sort(candidates.begin(), candidates.end());
    const Candidate* previous = nullptr;
    for (const Candidate& candidate : candidates) {
      const ViewChunk& chunk = batch.chunks[candidate.chunk];
      if (previous != nullptr && previous->chunk == candidate.chunk && previous->distance == candidate.distance) {
        ++draws.back().placements;
      } else {
        draws.push_back({chunk.firstTriangle, chunk.triangles, static_cast<std::uint32_t>(placements_.size()), 1});
      }
      previous = &candidate;
      VtkPlacement placement = frames_[candidate.frame].placement;
      // The shader adds a triangle's index in the batch to firstNumber, and the chunk's first triangle must get
      // nextNumber_. The difference may wrap around.
      placement.firstNumber = static_cast<std::uint32_t>(nextNumber_) - chunk.firstTriangle;
      placements_.push_back(placement);
      drawnChunks_.push_back({chunk.firstTriangle, candidate.frame, &batch});
      firstNumbers_.push_back(static_cast<std::uint32_t>(nextNumber_));
      nextNumber_ += chunk.triangles;
    }
    if (nextNumber_ > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(
          "the camera '{}' has {} triangles in view, more than can be told apart: take a smaller range, or ray tracing",
          camera_.name, nextNumber_);
    }
  }

  const Scene& scene_;
  const ViewGeometry& geometry_;
  Camera camera_;
  DrawLimits limits_;
  Mat3 cameraFromWorld_;
  std::vector<Frame> frames_;
  std::vector<VtkPlacement> placements_;  // by drawn chunk
  std::vector<VtkDraw> solid_;
  std::vector<VtkDraw> cut_;
  std::vector<DrawnChunk> drawnChunks_;
  std::vector<std::uint32_t> firstNumbers_;  // by drawn chunk: number of its first triangle in the image, ascending
  std::uint64_t nextNumber_ = 1;
};

// Calls `work`, which uses the plug-in, and rethrows its exceptions as Error with a message about this renderer.
template <class Work>
decltype(auto) withErrorWords(const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw Error("images cannot be drawn, memory is out: take smaller images or a smaller scene");
  } catch (const NoDevice& e) {
    throw Error("images cannot be drawn, this machine has no OpenGL 4.3 by EGL ({}): {}, or take ray tracing", e.what(),
                kInstallOpenGl);
  } catch (const std::exception& e) {
    throw Error("images cannot be drawn: {}", e.what());
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
    for (ViewBatch* batch : {&geometry.solid, &geometry.cut}) {  // frees the arrays that only the device needs
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

// Unlocks the renderer when its images are destroyed. The lock is a semaphore and not a mutex, because another thread
// than the thread that locked the renderer may destroy the images.
struct Unlock {
  void operator()(std::binary_semaphore* isFree) const { isFree->release(); }
};
using RendererLock = std::unique_ptr<std::binary_semaphore, Unlock>;

class VtkSource : public PixelSource {
 public:
  VtkSource(RendererLock lock, Device& device, const Scene& scene, std::vector<Camera> cameras,
            const DrawLimits& limits)
      : lock_(std::move(lock)), device_(device), cameras_(std::move(cameras)), firsts_(firstPixels(cameras_)) {
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
    parallelForEach(addresses.size(), kGrain, [&](std::size_t i) {
      if (numbers[i] == 0) return;
      const std::size_t image = imageOf(firsts_, addresses[i]);
      triangles[i] = views_[image].triangleAt(addresses[i] - firsts_[image], numbers[i]);
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
    if (cameras.size() > kVtkImages) throw Error("at most {} images can be drawn at once", kVtkImages);
    const std::uint32_t largestSide = device_.plugin->limits().imageSize;  // px
    for (const Camera& camera : cameras) {
      if (camera.width <= largestSide && camera.height <= largestSide) continue;
      throw InputError(
          fmt::format("the camera '{}' has {} x {} pixels: an image is at most {} pixels wide and high here",
                      camera.name, camera.width, camera.height, largestSide));
    }
    isFree_.acquire();
    return std::make_unique<VtkSource>(RendererLock(&isFree_), device_, scene_, cameras, limits);
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
