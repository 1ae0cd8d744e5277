// Renders with Blender's Cycles: the script scripts/blender_passes.py makes Blender write depths and ids into OpenEXR
// files. The renderer reads these files.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assets/meshes/blender.h"
#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "passes/blender/blender_scene.h"
#include "passes/exr/exr_file.h"
#include "passes/renderer.h"
#include "passes/resolver.h"

namespace scanmill {

namespace {

constexpr std::uint32_t kMinSide = 4;          // px, Blender's smallest image side
constexpr float kBlenderSky = 1e9f;            // m; pixels with a larger depth show no surface: Blender writes 1e10
constexpr float kExactIntegers = 16777216.0f;  // 2^24, up to which float32 represents every integer; larger object
                                               // numbers are written in two parts: see the script
constexpr double kReach = 512;                 // m, largest distance of the cameras from the scene's origin in Blender:
                                               // float32 steps are 6e-5 m there
constexpr double kPlaneShare = 1e-3;           // largest difference of Blender's depth from the depth of the triangle's
                                               // plane, as a fraction of the depth
constexpr std::size_t kFrameGrain = 1 << 14;   // number of pixels of one parallel task
// If more than this number of pixels of an image have a depth and no pixel has an id, Blender has not written ids: this
// is an error. If fewer pixels have a depth, all of them may be cut-outs.
constexpr std::ptrdiff_t kFewestWithoutIds = 1000;

// The visible triangle and depth of each pixel, from which a Resolver computes the passes.
class TriangleSource : public PixelSource {
 public:
  TriangleSource(std::shared_ptr<const Resolver> resolver, std::vector<Camera> cameras,
                 std::vector<VisibleTriangle> triangles)
      : resolver_(std::move(resolver)), cameras_(std::move(cameras)), triangles_(std::move(triangles)) {}

  const std::vector<Camera>& cameras() const override { return cameras_; }

  PassChoice available() const override { return {channelsThat(&ChannelRow::rendered), true}; }

  void fetch(std::span<const PixelAddress> addresses, PassChoice requested, PassPlanes& planes) override {
    fetched_.resize(addresses.size());
    parallelForEach(addresses.size(), kFrameGrain, [&](std::size_t i) {
      fetched_[i] = addresses[i] < triangles_.size() ? triangles_[addresses[i]] : VisibleTriangle{};
    });
    resolver_->resolve(cameras_, addresses, fetched_, requested, planes);
  }

 private:
  std::shared_ptr<const Resolver> resolver_;
  std::vector<Camera> cameras_;
  std::vector<VisibleTriangle> triangles_;  // the visible triangle of each pixel, indexed by PixelAddress
  std::vector<VisibleTriangle> fetched_;    // reused by each fetch
};

// Computes the depth of triangles' planes at the centres of one camera's pixels, in double precision. Blender's float32
// depth has an error of about 1e-7 of the triangle's size and distance, which is too much for a large triangle nearby.
class ExactDepth {
 public:
  ExactDepth(const Scene& scene, const Camera& camera) : scene_(scene), camera_(camera) {
    const Mat3 cameraFromWorld = transposed(toMatrix(camera.worldFromCamera.rotation));
    for (const Instance& instance : scene.instances) {
      const Affine& a = instance.worldFromMesh;
      cameraFromMesh_.push_back(
          {cameraFromWorld * a.linear, cameraFromWorld * (a.translation - camera.worldFromCamera.translation)});
    }
  }

  // Returns the depth (m) of the triangle's plane at a pixel's centre. Returns Blender's depth `visible.depth` instead
  // if the two differ by more than the fraction kPlaneShare, as they do for triangles seen edge-on.
  float depthAt(std::size_t column, std::size_t row, const VisibleTriangle& visible) const {
    const Affine& cameraFromMesh = cameraFromMesh_[visible.instance - 1];
    const Mesh& mesh = scene_.meshes[scene_.instances[visible.instance - 1].mesh];
    const Triangle& corners = mesh.triangles.at(visible.triangle);
    const auto corner = [&](int i) { return Vec3d(mesh.positions[corners[i]]); };
    const Vec3d a = corner(0);
    const Mat3& linear = cameraFromMesh.linear;
    const Vec3d normal = cross(linear * (corner(1) - a), linear * (corner(2) - a));
    const Vec3d sight = camera_.ray(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
    const double exact = dot(cameraFromMesh * a, normal) / dot(sight, normal);
    const double rendered = visible.depth;
    return std::abs(exact - rendered) <= kPlaneShare * rendered ? static_cast<float>(exact) : visible.depth;
  }

 private:
  const Scene& scene_;
  const Camera& camera_;
  std::vector<Affine> cameraFromMesh_;  // indexed as Scene::instances
};

class BlenderRenderer : public PassRenderer {
 public:
  explicit BlenderRenderer(const Scene& scene) : scene_(scene), resolver_(std::make_shared<Resolver>(scene)) {
    start();
  }

  std::unique_ptr<PixelSource> draw(const std::vector<Camera>& cameras, const DrawLimits& limits,
                                    PassChoice /*choice*/) override {
    const std::lock_guard lock(mutex_);
    try {
      if (!job_) start();
      if (!cameras.empty()) load(cameras[0].worldFromCamera.translation);
      return std::make_unique<TriangleSource>(resolver_, cameras, drawAll(cameras, limits));
    } catch (...) {
      job_.reset();  // otherwise the next answers would belong to requests from before the error
      origin_.reset();
      throw;
    }
  }

  std::string device() const override {
    const std::lock_guard lock(mutex_);
    return device_;
  }

 private:
  void start() {
    job_.emplace("render", folder_.path(), std::vector<std::string>{});
    threads_ = threadCount();
    const BlenderAnswer ready = job_->answer();
    device_ = fmt::format("Blender {} (Cycles on {} threads)", ready.text, threads_);
  }

  // Loads the scene into Blender, relative to the origin `near`. Does nothing if Blender already has the scene,
  // relative to an origin within kReach of `near`.
  void load(const Vec3d& near) {
    if (origin_ && length(near - *origin_) <= kReach) return;
    origin_ = near;
    objects_ = writeBlenderScene(scene_, near, threads_, folder_.path());
    job_->ask(nlohmann::json{{"scene", folder_.path().string()}}.dump());
    job_->answer();
  }

  // Renders all images. Returns the visible triangle of each pixel, indexed by PixelAddress. While one image is read,
  // Blender renders the next.
  std::vector<VisibleTriangle> drawAll(const std::vector<Camera>& cameras, const DrawLimits& limits) {
    const std::vector<PixelAddress> firsts = firstPixels(cameras);
    std::vector<VisibleTriangle> triangles(firsts.back());
    for (std::size_t i = 0; i < cameras.size(); ++i) job_->ask(requestText(cameras[i], limits, imageFile(i)));
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      job_->answer();
      readImage(imageFile(i), cameras[i], limits, &triangles[firsts[i]]);
      std::filesystem::remove(imageFile(i));
    }
    return triangles;
  }

  std::filesystem::path imageFile(std::size_t index) const { return folder_.path() / fmt::format("{}.exr", index); }

  // Returns the line of JSON that makes scripts/blender_passes.py render a camera's image into `file`.
  std::string requestText(const Camera& camera, const DrawLimits& limits, const std::filesystem::path& file) const {
    const auto& [rotation, translation] = camera.worldFromCamera;
    const std::array<double, 16> rows = matrixRows({toMatrix(rotation), translation - *origin_});
    return nlohmann::json{{"file", file.string()},
                          {"width", std::max(camera.width, kMinSide)},
                          {"height", std::max(camera.height, kMinSide)},
                          {"fx", camera.fx},
                          {"fy", camera.fy},
                          {"cx", camera.cx},
                          {"cy", camera.cy},
                          {"near", limits.nearest},
                          {"far", limits.farthest},
                          {"pose", std::vector<double>(rows.begin(), rows.begin() + 12)}}
        .dump();
  }

  // A pixel of Blender's image: the depth (m), the object's number (see kExactIntegers) and the triangle's number.
  struct BlenderPixel {
    float depth, objectLow, objectHigh, triangle;

    std::size_t object() const { return static_cast<std::size_t>(objectLow + kExactIntegers * objectHigh); }
  };

  // Reads all pixels. Blender puts the name of a layer before the name of a channel: "ViewLayer.Depth.Z".
  static std::vector<BlenderPixel> readPixels(const ExrReader& reader) {
    std::vector<BlenderPixel> pixels(reader.pixels());
    const auto target = [&](const char* nameEnd, float BlenderPixel::*member) {
      const auto channel = std::ranges::find_if(reader.channels(), [&](const ExrChannel& candidate) {
        return candidate.name.ends_with(nameEnd) && candidate.type == ExrType::Float32;
      });
      if (channel == reader.channels().end()) throw Error("Blender's image lacks the channel {}", nameEnd);
      return ExrTarget{&*channel, &(pixels.data()->*member), sizeof(BlenderPixel)};
    };
    reader.read(
        std::vector<ExrTarget>{target(".Depth.Z", &BlenderPixel::depth), target(".ids.R", &BlenderPixel::objectLow),
                               target(".ids.G", &BlenderPixel::objectHigh), target(".ids.B", &BlenderPixel::triangle)});
    return pixels;
  }

  // Reads an image that Blender has rendered; it may be larger than the camera's image (kMinSide). Sets the elements of
  // `triangles`, one per pixel of the camera's image, row by row, for pixels that show a surface.
  void readImage(const std::filesystem::path& file, const Camera& camera, const DrawLimits& limits,
                 VisibleTriangle* triangles) {
    const ExrReader reader(file);
    const std::vector<BlenderPixel> pixels = readPixels(reader);
    // A surface that is exactly at a depth limit may be rounded to either side of it, so this test includes the limits.
    const auto nearest = static_cast<float>(limits.nearest);
    const auto farthest = std::min(static_cast<float>(limits.farthest), kBlenderSky);
    const auto hasDepth = [&](const BlenderPixel& p) { return p.depth >= nearest && p.depth <= farthest; };
    const auto drawnPixels = std::ranges::count_if(pixels, hasDepth);
    if (drawnPixels > kFewestWithoutIds &&
        std::ranges::none_of(pixels, [](const BlenderPixel& p) { return p.objectLow > 0 || p.objectHigh > 0; })) {
      throw Error(
          "Blender drew {} pixels and wrote no object's number for any: this version of Blender does "
          "not fill the pass 'ids' as 3.4 to 4.3 do; SCANMILL_BLENDER names another one",
          drawnPixels);
    }
    const ExactDepth exact(scene_, camera);
    parallelForEach(camera.height, 1 + kFrameGrain / camera.width, [&](std::size_t row) {
      for (std::size_t column = 0; column < camera.width; ++column) {
        const BlenderPixel& pixel = pixels[row * reader.width() + column];
        if (!hasDepth(pixel) || pixel.object() == 0) continue;
        const BlenderObject& object = objects_.at(pixel.object() - 1);
        VisibleTriangle& visible = triangles[row * camera.width + column];
        visible = {pixel.depth, object.instance, object.firstTriangle + static_cast<std::uint32_t>(pixel.triangle)};
        visible.depth = std::clamp(exact.depthAt(column, row, visible), nearest, farthest);
      }
    });
  }

  const Scene& scene_;
  std::shared_ptr<const Resolver> resolver_;
  mutable std::mutex mutex_;  // guards all members below
  ScratchFolder folder_;
  std::optional<BlenderJob> job_;
  std::optional<Vec3d> origin_;  // m, world: origin of the scene in Blender; nothing: Blender has not loaded the scene
                                 // yet
  std::vector<BlenderObject> objects_;
  int threads_ = 1;
  std::string device_;
};

}  // namespace

std::unique_ptr<PassRenderer> makeBlenderRenderer(const Scene& scene) {
  return std::make_unique<BlenderRenderer>(scene);
}

}  // namespace scanmill
