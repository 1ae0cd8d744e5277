// The depth-camera method (LiDAR-GEIL): cameras at the sensor render depth, normals and ids, and beams look up their
// hits in the images.
//
// If a sensor moves during its revolution, the revolution is rendered in steps. Each column keeps its exact pose, but
// is sampled from the images of its step, which were rendered from a slightly different position. Flat surfaces
// therefore stay exact; errors occur only at surfaces that a column sees but the images of its step do not show.

#include "methods/depth_camera/depth_camera.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "assets/meshes/blender.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/recently_used.h"
#include "base/stage_clock.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr std::size_t kSensorsInMemory = 16;  // largest number of beam tables whose views are cached
constexpr double kReachMargin = 1e-3;         // images reach kReachMargin * (range + 1 m) beyond the sensor's range
// Memory, measured with VTK on llvmpipe. A process with an empty scene takes 128 MiB with this method, and 44 MiB with
// ray tracing; kBytesOfLibraries is the difference. The bytes per triangle and per pixel were measured in the scene
// "street" of 1.28 million placed triangles, with 3 and with 4 images of 2048 x 2048 pixels.
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

// Returns the path of Blender's program, or the reason why there is none.
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

constexpr double kStepLength = 0.05;         // m, largest mean length of the sensor's path in a step
constexpr double kStepAngle = radians(1.0);  // rad, largest mean rotation of the sensor in a step
constexpr std::size_t kFewPoses = 64;        // up to this number of poses, each pose is rendered
constexpr double kNearestSample = 0.1;       // m along a beam; the images need not show nearer points

// Returns the angle (rad) of the rotation from a to b.
double angleBetween(const Quat& a, const Quat& b) {
  const Quat between = Quat{a.w, -a.x, -a.y, -a.z} * b;
  return 2 * std::atan2(length(Vec3d{between.x, between.y, between.z}), std::abs(between.w));
}

// Returns the number of steps of a revolution if the options do not set the number: see stepsOf().
std::uint64_t rendersFor(const std::vector<Pose>& poses) {
  if (poses.size() <= kFewPoses) return poses.size();
  double pathLength = 0;  // m
  double rotation = 0;    // rad
  for (std::size_t i = 1; i < poses.size(); ++i) {
    pathLength += length(poses[i].translation - poses[i - 1].translation);
    rotation += angleBetween(poses[i - 1].rotation, poses[i].rotation);
  }
  const double renders = std::ceil(std::max({pathLength / kStepLength, rotation / kStepAngle, 1.0}));
  return static_cast<std::uint64_t>(std::min(renders, static_cast<double>(poses.size())));
}

// Returns the steps of a revolution, still without images. Each step has about equally many poses, and is rendered from
// its middle pose. `renders`: number of steps, at most the number of poses. If `renders` is 0, up to 64 poses get a
// step each; more poses get a step for every 5 cm or every degree of the sensor's motion, whichever gives more steps.
std::vector<PassStep> stepsOf(const Shot& shot, std::uint32_t renders) {
  const std::uint64_t poses = shot.worldFromSensor.size();
  const std::uint64_t columns = shot.beams->columns;
  const std::uint64_t count = std::min(renders == 0 ? rendersFor(shot.worldFromSensor) : renders, poses);
  const auto firstColumn = [&](std::uint64_t pose) {  // first column of a pose; exact if a beam has one ray
    return static_cast<std::uint32_t>((pose * columns + poses - 1) / poses);
  };
  std::vector<PassStep> steps;
  for (std::uint64_t step = 0; step < count; ++step) {
    const std::uint64_t first = step * poses / count;
    const std::uint64_t end = (step + 1) * poses / count;
    steps.push_back({.firstColumn = firstColumn(first),
                     .endColumn = firstColumn(end),
                     .worldFromRig = shot.worldFromSensor[(first + end - 1) / 2],
                     .images = {}});
  }
  return steps;
}

// Returns the beams of the columns [first, end), relative to the rig, ring by ring.
RigBeams rigBeams(const Shot& shot, std::uint32_t first, std::uint32_t end, const Pose& worldFromRig) {
  constexpr std::size_t kGrain = 16384;  // beams per task
  const BeamTable& table = *shot.beams;
  struct ColumnPose {  // rigFromSensor of a column
    bool isIdentity;
    Mat3 rotation;
    Vec3d translation;
  };
  std::vector<ColumnPose> poses;
  const Mat3 rigFromWorld = transposed(toMatrix(worldFromRig.rotation));
  bool hasOrigins = !table.origin.empty();
  for (std::uint32_t column = first; column < end; ++column) {
    const Pose& pose = shot.worldFromSensor[shot.stepOf(column)];
    // Subtract before rotating: far from the world's origin this keeps a precision of micrometres.
    poses.push_back({.isIdentity = pose == worldFromRig,
                     .rotation = rigFromWorld * toMatrix(pose.rotation),
                     .translation = rigFromWorld * (pose.translation - worldFromRig.translation)});
    hasOrigins = hasOrigins || !poses.back().isIdentity;
  }
  const std::size_t width = end - first;
  const std::size_t count = width * table.rings;
  RigBeams beams{.origin = std::vector<Vec3d>(hasOrigins ? count : 0),
                 .direction = std::vector<Vec3d>(count),
                 .beam = std::vector<std::uint32_t>(count),
                 .minRange = table.minRange,
                 .maxRange = table.maxRange};
  parallelForEach(table.rings, kGrain / width + 1, [&](std::size_t ring) {
    for (std::size_t c = 0; c < width; ++c) {
      const std::size_t i = ring * width + c;
      const std::size_t beam = ring * table.columns + first + c;
      const ColumnPose& pose = poses[c];
      beams.beam[i] = static_cast<std::uint32_t>(beam);
      beams.direction[i] = pose.isIdentity ? table.direction[beam] : pose.rotation * table.direction[beam];
      if (!hasOrigins) continue;
      const Vec3d origin = table.originOf(beam);
      beams.origin[i] = pose.isIdentity ? origin : pose.rotation * origin + pose.translation;
    }
  });
  return beams;
}

// Returns directions that the rig's cameras must cover to see everything that the beams can hit: the directions of the
// beams and, if beams do not start at the rig's origin, the directions of the nearest points that these beams can hit.
std::vector<Vec3d> viewDirections(const RigBeams& beams) {
  std::vector<Vec3d> directions = beams.direction;
  if (beams.origin.empty()) return directions;
  const double nearest = std::max(beams.minRange, kNearestSample);
  directions.reserve(2 * directions.size());
  for (std::size_t i = 0; i < beams.direction.size(); ++i) {
    directions.push_back(normalized(beams.origin[i] + beams.direction[i] * nearest));
  }
  return directions;
}

// The beams of one step of a revolution, and the cameras that render the step's images. If the sensor stands still,
// beams and cameras depend only on the beam table.
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
    std::uint64_t beamsInNoImage = 0;
    StageClock clock(kStages);
    for (const PassStep& step : stepsOf(shot, options_.rendersPerRevolution)) {
      const std::shared_ptr<const StepView> view = viewOf(shot, step);
      renderStep(shot, *view, step.worldFromRig, passes(channels), clock, [&](PixelSource& source) {
        beamsInNoImage += samplePixels(source, step.worldFromRig, view->beams, sampleOptions(*shot.beams), hits);
      });
    }
    return account(clock, shot, beamsInNoImage);
  }

  PassChoice passes(Channels channels) const override { return passesFor(channels, options_.sample); }

  TraceAccount draw(const Shot& shot, PassChoice choice, const std::function<void(PassStep&&)>& take) const override {
    requireRenderer();
    StageClock clock(kStages);
    for (PassStep& step : stepsOf(shot, options_.rendersPerRevolution)) {
      const std::shared_ptr<const StepView> view = viewOf(shot, step);
      renderStep(shot, *view, step.worldFromRig, choice, clock,
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
    std::uint64_t beamsInNoImage = 0;
    {
      const StageTimer timer(clock, "sample");
      beamsInNoImage = samplePixels(images, step.worldFromRig, view->beams, sampleOptions(*shot.beams), hits);
    }
    return account(clock, shot, beamsInNoImage);
  }

  std::vector<ModelledItem> modelled() const override {
    std::vector<ModelledItem> items;
    if (makeRenderer_) {
      const std::string renders = options_.rendersPerRevolution > 0
                                      ? fmt::format("{} renders", options_.rendersPerRevolution)
                                      : "one render for every 5 cm or degree of motion";
      items.push_back(
          {"images", fmt::format("layout {}, resolution {}, drawn by {}; moving sensors: {} per revolution",
                                 options_.layoutName, options_.layout.resolution, options_.renderer, renders)});
      if (options_.renderer == "blender") items.push_back({"Blender", whereBlenderIs()});
    } else {
      items.push_back({"images", "passes from files"});
    }
    const char* const accuracy = options_.sample.sampling == Sampling::Plane
                                     ? ": exact on flat surfaces, edges to within a pixel"
                                     : ": to within a pixel";
    items.push_back({"geometry", fmt::format("one hit per ray, sampling {}, depth {}{}", options_.samplingName,
                                             options_.depthName, accuracy)});
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
    // The layout "auto" is counted as three square images, more than most sensors need. If the sensor moves, only the
    // images of one step are in memory.
    const std::uint64_t width = options_.layout.resolution;
    const std::uint64_t images = options_.layout.layout == CameraLayout::Cube6    ? 6
                                 : options_.layout.layout == CameraLayout::Four90 ? 4
                                                                                  : 3;
    return kBytesOfLibraries + scene_->triangles() * kBytesPerSceneTriangle +
           scene_->placedTriangles() * kBytesPerPlacedTriangle + images * width * width * kBytesPerPixel;
  }

 private:
  // Returns the view of a step. The view of a sensor that stands still is made once for each beam table.
  std::shared_ptr<const StepView> viewOf(const Shot& shot, const PassStep& step) const {
    const bool hasAllColumns = step.endColumn - step.firstColumn == shot.beams->columns;
    const bool standsStill = shot.worldFromSensor.size() == 1 && step.worldFromRig == shot.worldFromSensor[0];
    if (!standsStill || !hasAllColumns) return makeView(shot, step);
    const std::scoped_lock lock(viewsMutex_);
    return stillViews_.findOrAdd([&](const auto& view) { return view->table == shot.beams; }, kSensorsInMemory,
                                 [&] { return makeView(shot, step); });
  }

  std::shared_ptr<const StepView> makeView(const Shot& shot, const PassStep& step) const {
    auto view = std::make_shared<StepView>();
    view->table = shot.beams;
    view->beams = rigBeams(shot, step.firstColumn, step.endColumn, step.worldFromRig);
    if (makeRenderer_) view->cameras = layOutCameras(viewDirections(view->beams), options_.layout);
    return view;
  }

  SampleOptions sampleOptions(const BeamTable& table) const {
    SampleOptions sample = options_.sample;
    sample.farthest = options_.farthest > 0 ? options_.farthest : table.maxRange;
    return sample;
  }

  // Returns the depth limits of the images. `origins`: the beams' origins (m, rig axes); empty if all are zero.
  DrawLimits limits(const BeamTable& table, const std::vector<Vec3d>& origins) const {
    double farthestOrigin2 = 0;  // m^2
    for (const Vec3d& origin : origins) farthestOrigin2 = std::max(farthestOrigin2, dot(origin, origin));
    const double reach = (table.maxRange + std::sqrt(farthestOrigin2)) * (1 + kReachMargin) + kReachMargin;
    const double farthest = options_.farthest > 0 ? options_.farthest : std::max(reach, 2 * options_.sample.nearest);
    return {.nearest = options_.sample.nearest, .farthest = farthest, .reach = reach};
  }

  void requireRenderer() const {
    if (!makeRenderer_) throw Error("the passes are read from files, so that no images can be drawn");
  }

  // Returns the renderer, created at the first call. The caller must have locked rendererMutex_.
  PassRenderer& renderer() const {
    if (!renderer_) renderer_ = makeRenderer_();
    return *renderer_;
  }

  // Renders a step and calls `use` with its pixels. Only one thread renders at a time; the time in which a thread waits
  // for another to finish is not added to `clock`.
  template <class Use>
  void renderStep(const Shot& shot, const StepView& view, const Pose& worldFromRig, PassChoice choice,
                  StageClock& clock, const Use& use) const {
    if (view.cameras.empty()) {  // no camera of the layout sees any of the beams
      ImageSource noImages({});
      use(noImages);
      return;
    }
    std::vector<Camera> cameras = view.cameras;
    for (Camera& camera : cameras) camera.worldFromCamera = worldFromRig * camera.worldFromCamera;
    const std::scoped_lock lock(rendererMutex_);
    const WallTimer renderTimer;
    const std::unique_ptr<PixelSource> source =
        renderer().draw(cameras, limits(*shot.beams, view.beams.origin), choice);
    clock.add("render", renderTimer.seconds());
    const WallTimer useTimer;
    TimedSource timedSource(*source);
    use(timedSource);
    clock.add("read_back", timedSource.seconds());
    clock.add("sample", useTimer.seconds() - timedSource.seconds());
  }

  // Returns a shot's stage times, with a warning if `beamsInNoImage`, its number of beams in no image, is not 0.
  TraceAccount account(const StageClock& clock, const Shot& shot, std::uint64_t beamsInNoImage) const {
    TraceAccount account{clock.seconds(), {}};
    if (beamsInNoImage == 0) return account;
    account.warn({.sensor = shot.sensorName,
                  .kind = 0,
                  .count = beamsInNoImage,
                  .text = fmt::format("{} of {} beams of '{}' are outside all images{} and count as misses: {}",
                                      beamsInNoImage, shot.beams->size(), shot.sensorName,
                                      makeRenderer_ ? " of layout " + options_.layoutName : "",
                                      makeRenderer_ ? "take `layout: auto`" : "draw images that cover them")});
    return account;
  }

  const Scene* scene_;  // null if the passes come from files
  DepthCameraOptions options_;
  RendererMaker makeRenderer_;  // null if the passes come from files
  mutable std::mutex rendererMutex_;
  mutable std::unique_ptr<PassRenderer> renderer_;
  mutable std::mutex viewsMutex_;
  mutable RecentlyUsed<std::shared_ptr<const StepView>> stillViews_;  // views of sensors that stand still
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
