#include "methods/depth_camera/revolution.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr double kStepLength = 0.05;         // m, largest mean length of the sensor's path in a step
constexpr double kStepAngle = radians(1.0);  // rad, largest mean rotation of the sensor in a step
constexpr std::size_t kFewPoses = 64;        // up to this number, each pose is rendered
constexpr double kNearestSample = 0.1;       // m along a beam; nearer points need not be visible

// Returns the angle (rad) of the rotation from a to b.
double angleBetween(const Quat& a, const Quat& b) {
  const Quat between = Quat{a.w, -a.x, -a.y, -a.z} * b;
  return 2 * std::atan2(std::sqrt(between.x * between.x + between.y * between.y + between.z * between.z),
                        std::abs(between.w));
}

// Returns the number of renders of a revolution if the options do not set it: see stepsOf().
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

}  // namespace

std::vector<PassStep> stepsOf(const Shot& shot, std::uint32_t renders) {
  const std::uint64_t poses = shot.worldFromSensor.size();
  const std::uint64_t columns = shot.beams->columns;
  const std::uint64_t count = std::min(renders == 0 ? rendersFor(shot.worldFromSensor) : renders, poses);
  const auto firstColumn = [&](std::uint64_t pose) {  // first column of this pose; exact with one ray per beam
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
  parallelFor(table.rings, kGrain / width + 1, [&](std::size_t firstRing, std::size_t endRing) {
    for (std::size_t ring = firstRing; ring < endRing; ++ring) {
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
    }
  });
  return beams;
}

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

}  // namespace scanmill
