#pragma once

// Places a vehicle on the ground, whatever heights its path was given with.

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
  // Returns the height (m) of the highest surface at this place that is below it or at most 0.5 m above it; if there is
  // none, that of the lowest surface above it. Nothing if there is no surface at all.
  virtual std::optional<double> under(const Vec3d& place) const = 0;
  // Returns the height (m) of the surface nearest to this place, at most 1.5 m below or above it; nothing if there is
  // none.
  virtual std::optional<double> near(const Vec3d& place) const = 0;
};

// Read from YAML: `drop`, or {height: 1.8, wheels: [2.7, 1.6], on: [road, terrain]}.
struct GroundOptions {
  double height = 0;                                        // m, of the vehicle's origin above the ground
  std::optional<std::array<double, 2>> wheels{{2.7, 1.6}};  // m, wheelbase and track; none: it stays upright
  std::vector<std::string> classes;                         // on which it is placed; empty: all that are not things
  Location where;
};

// Throws InputError.
GroundOptions readGround(const Value& value);

// Heights and slopes of the ground under a vehicle along its path.
class GroundProfile {
 public:
  // Returns the vehicle's pose at a place on the path, given in m or s, before it is placed on the ground.
  using Way = std::function<Pose(double)>;

  // Samples the ground at these places of the path, in ascending order. At the start it is the ground under the pose,
  // later the ground nearest in height to the previous sample, so that bridges and what lies beneath are not confused.
  // Over gaps the vehicle keeps its height; after 10 m without ground, the ground under the pose is taken again. Throws
  // InputError at `options.where` if the whole path has no ground.
  GroundProfile(const GroundOptions& options, const Way& way, std::vector<double> places, const Ground& ground);

  // Returns places at most 0.1 m apart between ascending knots. Between two knots the path must be about straight and
  // the speed about even. Throws InputError at `where` for more than ten million places.
  static std::vector<double> placesOf(const Way& way, const std::vector<double>& knots, const Location& where);

  // Places a pose on the ground: it keeps its horizontal position and heading, and gets the ground's height, pitch and
  // roll.
  Pose place(const Pose& pose, double at) const;
  // Returns the share of the path without ground, where the heights around are kept.
  double bare() const { return bare_; }

 private:
  struct Sample {
    double height = 0;           // m
    double along = 0, left = 0;  // slopes, up is positive
  };
  static std::vector<Sample> evened(const std::vector<Sample>& samples, const std::vector<double>& driven);

  double bare_ = 0;
  std::vector<double> places_;
  std::vector<Sample> samples_;
};

// Places a single pose on the ground; its own pitch and roll are added to those of the ground. Throws InputError if
// there is no ground.
Pose onGround(const GroundOptions& options, const Pose& pose, const Ground& ground);

}  // namespace scanmill
