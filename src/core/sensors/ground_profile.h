#pragma once

// Places a vehicle on the ground instead of at the heights of its path.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// The surfaces of a scene on which vehicles are placed.
class Ground {
 public:
  virtual ~Ground() = default;
  // Returns the height (m) of the highest surface that is below `point` or at most 0.5 m above it. If no surface is
  // that low, returns the height of the lowest surface above `point`; nothing if there is no surface at all.
  virtual std::optional<double> under(const Vec3d& point) const = 0;
  // Returns the height (m) of the surface nearest to `point`; nothing if none is within 1.5 m below or above it.
  virtual std::optional<double> near(const Vec3d& point) const = 0;
};

// How a vehicle is placed on the ground. In YAML: `drop`, or {height: 1.8, wheels: [2.7, 1.6], on: [road, terrain]}.
struct GroundOptions {
  // True for waypoints and random drives without the key `ground`: the vehicle stands on the ground only if its path is
  // at the height of the ground. Otherwise it flies, or the path is a sensor's or on things, and it keeps its heights.
  bool onlyIfAtGround = false;
  double height = 0;                                        // m, height of the vehicle's origin above the ground
  std::optional<std::array<double, 2>> wheels{{2.7, 1.6}};  // m, wheelbase and track; none: the vehicle stays upright
  std::vector<std::string> classes;                         // classes of the ground; empty: all except thing classes
  Location where;
};

// Reads the options from `value`, the value of the key `ground`; nothing for `none`. Throws InputError.
std::optional<GroundOptions> readGround(const Value& value);

// The height and the slopes of the ground under a vehicle at one position.
struct GroundSample {
  double height = 0;           // m
  double along = 0, left = 0;  // slopes ahead and to the left, as a ratio; positive is upwards
};

// Heights and slopes of the ground under a vehicle along its path.
class GroundProfile {
 public:
  // Returns the vehicle's pose at a position on the path (in m or s), before the pose is placed on the ground.
  using PoseOnPath = std::function<Pose(double)>;

  // Samples the ground at ascending `positions` on the path. The first sample is the ground under the pose; each later
  // sample is the ground nearest in height to the previous sample, so that a bridge is not confused with what lies
  // beneath it. Over gaps the vehicle keeps its height; after 10 m without ground, ground at any height is accepted.
  // If no part of the path has ground, throws InputError at `options.where`; if `options.onlyIfAtGround`, place() must
  // then not be called.
  GroundProfile(const GroundOptions& options, const PoseOnPath& poseOnPath, std::vector<double> positions,
                const Ground& ground);

  // Returns positions on the path, at most 0.1 m apart, between ascending knots. Between two knots the path must be
  // nearly straight and the speed nearly constant. Throws InputError at `where` for more than ten million positions.
  static std::vector<double> samplePositions(const PoseOnPath& poseOnPath, const std::vector<double>& knots,
                                             const Location& where);

  // Returns a pose placed on the ground: with the horizontal position and heading of `pose`, the ground's pitch and
  // roll, and GroundOptions::height above the ground. `position`: the position on the path.
  [[nodiscard]] Pose place(const Pose& pose, double position) const;
  // Returns the fraction of the path's samples for which no ground was found, and which copy another sample.
  double bareFraction() const { return bareFraction_; }

 private:
  double bareFraction_ = 0;
  std::vector<double> positions_;
  std::vector<GroundSample> samples_;  // with GroundOptions::height added
};

// Returns the pose on the ground, with its own pitch and roll added to the ground's. Throws InputError without ground.
[[nodiscard]] Pose onGround(const GroundOptions& options, const Pose& pose, const Ground& ground);

}  // namespace scanmill
