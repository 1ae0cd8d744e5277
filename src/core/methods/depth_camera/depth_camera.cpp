// The depth-camera method (LiDAR-GEIL): cameras at the sensor render depth, normals and ids, and beams look up their
// hits in the images.
//
// If a sensor moves during its revolution, the revolution is rendered in steps. Each column keeps its exact pose, but
// is sampled from the images of its step, which were rendered from a slightly different position. Flat surfaces
// therefore stay exact; errors occur only at surfaces that are hidden from the position of the images.

#include "methods/depth_camera/depth_camera.h"

#include <fmt/core.h>

#include <algorithm>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "assets/meshes/blender.h"
#include "base/error.h"
#include "base/recently_used.h"
#include "base/stage_clock.h"
#include "config/fields.h"
#include "methods/depth_camera/revolution.h"

namespace scanmill {

namespace {

constexpr std::size_t kSensorsInMemory = 16;
constexpr double kSlack = 1e-3;  // fraction of the sensor's range, and metres, by which images reach beyond it
// Measured with VTK on llvmpipe, as differences between processes: with nothing to render a process takes 128 MiB,
// against 44 MiB with ray tracing. The other two values are from the street of 1.28 million placed triangles, with 3
// and with 4 images of 2048 x 2048.
constexpr std::uint64_t kBytesOfLibraries = std::uint64_t{85} << 20;
constexpr std::uint64_t kBytesPerPlacedTriangle = 60;
constexpr std::uint64_t kBytesPerPixel = 16;
constexpr std::initializer_list<const char*> kStages = {"render", "read_back", "sample"};

// The map `depth_camera: {...}` of a pipeline.
struct DepthCameraOptions {
  std::string renderer;  // "vtk" or "blender"
  std::string layoutName;
  std::string samplingName;
  std::string depthName;
  LayoutOptions layout;
  SampleOptions sample;                    // without `farthest`, which is set for each shot
  double farthest = 0;                     // m, largest depth in the images; 0: the sensor's maximum range
  std::uint32_t rendersPerRevolution = 0;  // steps of a revolution that are rendered; 0: see stepsOf()
};

constexpr std::pair<const char*, CameraLayout> kLayouts[] = {{"auto", CameraLayout::Auto},
                                                             {"three_120", CameraLayout::Three120},
                                                             {"four_90", CameraLayout::Four90},
                                                             {"cube_6", CameraLayout::Cube6}};
constexpr std::pair<const char*, Sampling> kSamplings[] = {{"plane", Sampling::Plane}, {"nearest", Sampling::Nearest}};
constexpr std::pair<const char*, DepthFormat> kDepths[] = {{"float32", DepthFormat::Float32},
                                                           {"uint24", DepthFormat::Unorm24},
                                                           {"uint16", DepthFormat::Unorm16},
                                                           {"half_500", DepthFormat::Half500}};

DepthCameraOptions readDepthCameraOptions(Fields& fields) {
  DepthCameraOptions options;
  options.renderer = fields.choice("renderer", {"vtk", "blender"}, "vtk");
  std::tie(options.layoutName, options.layout.layout) = namedChoice(fields, "layout", kLayouts, CameraLayout::Auto);
  options.layout.resolution = static_cast<std::uint32_t>(fields.integer("resolution", 128, 4096, 2048));
  std::tie(options.samplingName, options.sample.sampling) =
      namedChoice(fields, "sampling", kSamplings, Sampling::Plane);
  std::tie(options.depthName, options.sample.depth) = namedChoice(fields, "depth", kDepths, DepthFormat::Float32);
  options.sample.nearest = fields.number("near_m", {1e-3, 1}, 0.01);
  options.farthest = fields.number("far_m", {10, 1e4}, 0);
  const Value* renders = fields.find("renders_per_turn");
  if (renders != nullptr && !(renders->kind == Value::Kind::Scalar && renders->text == "auto")) {
    options.rendersPerRevolution = static_cast<std::uint32_t>(fields.integer("renders_per_turn", 1, 65536));
  }
  fields.finish();
  return options;
}

std::string whereBlenderIs() {
  try {
    return blenderProgram().string();
  } catch (const Error& e) {
    return fmt::format("not found: {}", e.what());
  }
}

// A source that measures how long its caller waits for pixels.
class TimedSource : public PixelSource {
 public:
  explicit TimedSource(PixelSource& source) : source_(source) {}
  const std::vector<Camera>& cameras() const override { return source_.cameras(); }
  PassChoice available() const override { return source_.available(); }
  void fetch(std::span<const PixelAddress> addresses, PassChoice requested, PassPlanes& planes) override {
    const WallTimer timer;
    source_.fetch(addresses, requested, planes);
    seconds_ += timer.seconds();
  }
  double seconds() const { return seconds_; }

 private:
  PixelSource& source_;
  double seconds_ = 0;
};

// The beams of a step of a revolution and, for rendering, its cameras. If the sensor stands still, they depend only on
// the beam table.
struct StepView {
  std::shared_ptr<const BeamTable> table;
  RigBeams beams;
  std::vector<Camera> cameras;  // Camera::worldFromCamera is rigFromCamera here
};

class DepthCameraMethod : public DepthCamera {
 public:
  DepthCameraMethod(const Scene* scene, DepthCameraOptions options, RendererMaker makeRenderer)
      : scene_(scene), options_(std::move(options)), makeRenderer_(std::move(makeRenderer)) {}

  TraceAccount prepare(const Shot& shot) const override {
    if (shot.worldFromSensor.size() == 1) viewOf(shot, stepsOf(shot, 1).front());
    if (!makeRenderer_) return {};
    Camera smallest = squareCamera(2, 2, radians(60.0));
    smallest.worldFromCamera = shot.worldFromSensor.front();
    const std::scoped_lock lock(rendererMutex_);
    renderer().draw({smallest}, limits(*shot.beams, {}), {});
    return {};
  }

  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    requireRenderer();
    hits.reset(shot.beams->rings, shot.beams->columns, channels);
    std::uint64_t unseen = 0;
    StageClock clock(kStages);
    for (const PassStep& step : stepsOf(shot, options_.rendersPerRevolution)) {
      const std::shared_ptr<const StepView> view = viewOf(shot, step);
      drawn(shot, *view, step.worldFromRig, passesFor(channels, options_.sample), clock, [&](PixelSource& source) {
        unseen += samplePixels(source, step.worldFromRig, view->beams, sampleOptions(*shot.beams), hits);
      });
    }
    return account(clock, shot, unseen);
  }

  PassChoice passes(Channels channels) const override { return passesFor(channels, options_.sample); }

  TraceAccount draw(const Shot& shot, PassChoice choice, const std::function<void(PassStep&&)>& take) const override {
    requireRenderer();
    StageClock clock(kStages);
    for (PassStep& step : stepsOf(shot, options_.rendersPerRevolution)) {
      const std::shared_ptr<const StepView> view = viewOf(shot, step);
      drawn(shot, *view, step.worldFromRig, choice, clock,
            [&](PixelSource& source) { step.images = readAll(source, choice); });
      take(std::move(step));
    }
    return account(clock, shot, 0);
  }

  TraceAccount sample(const Shot& shot, const PassStep& step, Hits& hits) const override {
    if (step.endColumn > shot.beams->columns || step.firstColumn >= step.endColumn) {
      throw InputError(fmt::format("the passes have the columns {} to {}, but the sensor '{}' has {} columns",
                                   step.firstColumn, step.endColumn, shot.sensorName, shot.beams->columns));
    }
    const std::shared_ptr<const StepView> view = viewOf(shot, step);
    ImageSource images(step.images);
    StageClock clock(kStages);
    std::uint64_t unseen = 0;
    {
      const StageTimer timer(clock, "sample");
      unseen = samplePixels(images, step.worldFromRig, view->beams, sampleOptions(*shot.beams), hits);
    }
    return account(clock, shot, unseen);
  }

  std::vector<ModelledItem> modelled() const override {
    std::vector<ModelledItem> items;
    if (makeRenderer_) {
      items.push_back({"images", fmt::format("layout {}, resolution {}, drawn by {}; moving sensors: {} per revolution",
                                             options_.layoutName, options_.layout.resolution, options_.renderer,
                                             options_.rendersPerRevolution > 0
                                                 ? fmt::format("{} renders", options_.rendersPerRevolution)
                                                 : std::string("one render for every 5 cm or degree of motion"))});
      if (options_.renderer == "blender") items.push_back({"Blender", whereBlenderIs()});
    } else {
      items.push_back({"images", "passes from files"});
    }
    items.push_back(
        {"geometry",
         fmt::format("one hit per ray, sampling {}, depth {}{}", options_.samplingName, options_.depthName,
                     options_.sample.sampling == Sampling::Plane ? ": exact on flat surfaces, edges to within a pixel"
                                                                 : ": to within a pixel")});
    items.push_back({fmt::format("surfaces nearer to a camera's plane than {:g} m", options_.sample.nearest),
                     "beams pass through them", true});
    if (scene_ != nullptr) {
      items.push_back(cutOutItem(*scene_));
      items.push_back(textureItem(*scene_));
    }
    {
      const std::scoped_lock lock(rendererMutex_);
      if (renderer_) items.push_back({"images were drawn by", renderer_->device()});
    }
    items.push_back({"transmission through glass, mirror images, motion of objects", "", true});
    return items;
  }

  std::uint64_t memoryBytes() const override {
    if (scene_ == nullptr) return 0;
    // The layout "auto" is counted as three square images, more than most sensors need. Of a moving sensor, only the
    // images of one step are in memory.
    const std::uint64_t width = options_.layout.resolution;
    const std::uint64_t images = options_.layout.layout == CameraLayout::Cube6    ? 6
                                 : options_.layout.layout == CameraLayout::Four90 ? 4
                                                                                  : 3;
    return kBytesOfLibraries + scene_->triangles() * kBytesPerSceneTriangle +
           scene_->placedTriangles() * kBytesPerPlacedTriangle + images * width * width * kBytesPerPixel;
  }

 private:
  std::shared_ptr<const StepView> viewOf(const Shot& shot, const PassStep& step) const {
    const bool allColumns = step.endColumn - step.firstColumn == shot.beams->columns;
    if (shot.worldFromSensor.size() == 1 && allColumns && step.worldFromRig == shot.worldFromSensor[0]) {
      return stillView(shot, step);
    }
    return makeView(shot, step);
  }

  std::shared_ptr<const StepView> makeView(const Shot& shot, const PassStep& step) const {
    auto made = std::make_shared<StepView>();
    made->table = shot.beams;
    made->beams = rigBeams(shot, step.firstColumn, step.endColumn, step.worldFromRig);
    if (makeRenderer_) made->cameras = layOutCameras(viewDirections(made->beams), options_.layout);
    return made;
  }

  // Returns the view of a sensor that stands still, which is made once for each beam table.
  std::shared_ptr<const StepView> stillView(const Shot& shot, const PassStep& step) const {
    const std::scoped_lock lock(sensorsMutex_);
    return sensors_.findOrAdd([&](const auto& view) { return view->table == shot.beams; }, kSensorsInMemory,
                              [&] { return makeView(shot, step); });
  }

  SampleOptions sampleOptions(const BeamTable& table) const {
    SampleOptions sample = options_.sample;
    sample.farthest = options_.farthest > 0 ? options_.farthest : table.maxRange;
    return sample;
  }

  DrawLimits limits(const BeamTable& table, const std::vector<Vec3d>& origins) const {
    double offset = 0;
    for (const Vec3d& origin : origins) offset = std::max(offset, dot(origin, origin));
    const double reach = (table.maxRange + std::sqrt(offset)) * (1 + kSlack) + kSlack;
    const double farthest = options_.farthest > 0 ? options_.farthest : std::max(reach, 2 * options_.sample.nearest);
    return {options_.sample.nearest, farthest, reach};
  }

  void requireRenderer() const {
    if (!makeRenderer_) throw Error("the passes are read from files, so that no images can be drawn");
  }

  // Returns the renderer, created at the first call. The caller must have locked rendererMutex_.
  PassRenderer& renderer() const {
    if (!renderer_) renderer_ = makeRenderer_();
    return *renderer_;
  }

  // Renders a step and calls `use` with its pixels. Only one thread at a time does this; the time that a thread waits
  // for the renderer is not added to `clock`.
  template <class Use>
  void drawn(const Shot& shot, const StepView& view, const Pose& rig, PassChoice choice, StageClock& clock,
             const Use& use) const {
    if (view.cameras.empty()) {  // no camera of the layout sees any of the beams
      ImageSource nothing({});
      use(nothing);
      return;
    }
    std::vector<Camera> cameras = view.cameras;
    for (Camera& camera : cameras) camera.worldFromCamera = rig * camera.worldFromCamera;
    const DrawLimits bounds = limits(*shot.beams, view.beams.origin);
    const std::scoped_lock lock(rendererMutex_);
    const WallTimer drawing;
    const std::unique_ptr<PixelSource> source = renderer().draw(cameras, bounds, choice);
    clock.add("render", drawing.seconds());
    const WallTimer sampling;
    TimedSource timed(*source);
    use(timed);
    clock.add("read_back", timed.seconds());
    clock.add("sample", sampling.seconds() - timed.seconds());
  }

  // Returns the account of a shot. `unseen`: number of the shot's beams that are in no image.
  TraceAccount account(const StageClock& clock, const Shot& shot, std::uint64_t unseen) const {
    TraceAccount account{clock.seconds(), {}};
    if (unseen == 0) return account;
    account.warn(
        {shot.sensorName, 0, unseen,
         fmt::format("{} of {} beams of '{}' are outside all images{} and count as misses: {}", unseen,
                     shot.beams->size(), shot.sensorName, makeRenderer_ ? " of layout " + options_.layoutName : "",
                     makeRenderer_ ? "take `layout: auto`" : "draw images that cover them")});
    return account;
  }

  const Scene* scene_;  // null if the passes come from files
  DepthCameraOptions options_;
  RendererMaker makeRenderer_;
  mutable std::mutex rendererMutex_;
  mutable std::unique_ptr<PassRenderer> renderer_;
  mutable std::mutex sensorsMutex_;
  mutable RecentlyUsed<std::shared_ptr<const StepView>> sensors_;  // views of sensors that stand still
};

}  // namespace

std::unique_ptr<Method> makeDepthCamera(const Scene& scene, Fields& options) {
  DepthCameraOptions read = readDepthCameraOptions(options);
  const bool blender = read.renderer == "blender";
  return std::make_unique<DepthCameraMethod>(&scene, std::move(read), [&scene, blender] {
    return blender ? makeBlenderRenderer(scene) : makeVtkRenderer(scene);
  });
}

std::unique_ptr<DepthCamera> makeDepthCamera(const Scene& scene, Fields& options, RendererMaker renderer) {
  return std::make_unique<DepthCameraMethod>(&scene, readDepthCameraOptions(options), std::move(renderer));
}

std::unique_ptr<DepthCamera> makePassSampler(Fields& options) {
  return std::make_unique<DepthCameraMethod>(nullptr, readDepthCameraOptions(options), RendererMaker());
}

}  // namespace scanmill
