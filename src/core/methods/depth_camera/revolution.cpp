#include "methods/depth_camera/revolution.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace scanmill {

namespace {

constexpr double kStepLength = 0.05;         // m, largest mean length of the sensor's path in a step
constexpr double kStepAngle = radians(1.0);  // rad, largest mean rotation of the sensor in a step
constexpr std::size_t kFewPoses = 64;
constexpr double kNearestSample = 0.1;  // m along a beam; nearer points need not be visible

double angleBetween(const Quat& a, const Quat& b) {
  const Quat between = Quat{a.w, -a.x, -a.y, -a.z} * b;
  return 2 * std::atan2(std::sqrt(between.x * between.x + between.y * between.y + between.z * between.z),
                        std::abs(between.w));
}

std::uint64_t rendersFor(const std::vector<Pose>& poses) {
  if (poses.size() <= kFewPoses) return poses.size();
  double moved = 0;
  double turned = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    moved += length(poses[i].translation - poses[i - 1].translation);
    turned += angleBetween(poses[i - 1].rotation, poses[i].rotation);
  }
  const double wanted = std::ceil(std::max({moved / kStepLength, turned / kStepAngle, 1.0}));
  return static_cast<std::uint64_t>(std::min(wanted, static_cast<double>(poses.size())));
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
    steps.push_back({firstColumn(first), firstColumn(end), shot.worldFromSensor[(first + end - 1) / 2], {}});
  }
  return steps;
}

RigBeams rigBeams(const Shot& shot, std::uint32_t first, std::uint32_t end, const Pose& worldFromRig) {
  const BeamTable& table = *shot.beams;
  struct Place {
    bool same;
    Mat3 rotation;
    Vec3d translation;
  };
  std::vector<Place> places;
  const Mat3 rigFromWorld = transposed(toMatrix(worldFromRig.rotation));
  bool moved = !table.origin.empty();
  for (std::uint32_t column = first; column < end; ++column) {
    const Pose& pose = shot.worldFromSensor[shot.stepOf(column)];
    const bool same = pose == worldFromRig;
    // Subtract before rotating: far from the world's origin this keeps a precision of micrometres.
    places.push_back(
        {same, rigFromWorld * toMatrix(pose.rotation), rigFromWorld * (pose.translation - worldFromRig.translation)});
    moved = moved || !same;
  }
  const std::size_t width = end - first;
  RigBeams beams;
  beams.direction.resize(width * table.rings);
  beams.origin.resize(moved ? width * table.rings : 0);
  beams.beam.resize(width * table.rings);
  beams.minRange = table.minRange;
  beams.maxRange = table.maxRange;
  parallelFor(table.rings, 16384 / width + 1, [&](std::size_t firstRing, std::size_t endRing) {
    for (std::size_t ring = firstRing; ring < endRing; ++ring) {
      for (std::size_t c = 0; c < width; ++c) {
        const std::size_t to = ring * width + c;
        const std::size_t beam = ring * table.columns + first + c;
        const Place& place = places[c];
        beams.beam[to] = static_cast<std::uint32_t>(beam);
        beams.direction[to] = place.same ? table.direction[beam] : place.rotation * table.direction[beam];
        if (!moved) continue;
        const Vec3d origin = table.originOf(beam);
        beams.origin[to] = place.same ? origin : place.rotation * origin + place.translation;
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
