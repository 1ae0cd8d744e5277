#pragma once

// A vehicle that stands on the ground, whatever the heights that its way was given with.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"

namespace scanmill {

// The surfaces of a scene that vehicles stand on.
class Ground {
 public:
  virtual ~Ground() = default;
  // The height (m) of the highest at this place that is below it, or not more than 0.5 m above; where there is none, of
  // the lowest that is above. Nothing where there is none at all.
  virtual std::optional<double> under(const Vec3d& place) const = 0;
  // The height of that which is nearest to it, at most 1.5 m below or above.
  virtual std::optional<double> near(const Vec3d& place) const = 0;
};

// From YAML: `drop`, or {height: 1.8, wheels: [2.7, 1.6], on: [road, terrain]}.
struct GroundOptions {
  double height = 0;                                        // m, of the vehicle's origin above the ground
  std::optional<std::array<double, 2>> wheels{{2.7, 1.6}};  // m, wheelbase and track; none: it stays upright
  std::vector<std::string> classes;                         // that it stands on; empty: all that are no things
  Location where;
};

// Throws InputError.
GroundOptions readGround(const Value& value);

// Heights and slopes under a vehicle along its way.
class GroundProfile {
 public:
  // The vehicle's pose, as far as the way knows it, at a place on the way, which is counted in m or s.
  using Way = std::function<Pose(double)>;

  // At these places of the way, which ascend. The ground at the start is that under the pose; from there on that which
  // is nearest in height to that before, so that bridges and what lies beneath are told apart: over gaps the vehicle
  // keeps its height, and only after 10 m without ground it is looked for anew under the pose. Throws InputError at
  // `options.where` where there is no ground along the whole way.
  GroundProfile(const GroundOptions& options, const Way& way, std::vector<double> places, const Ground& ground);

  // Places 0.1 m apart or less between the knots, which ascend and between which the way is about straight and evenly
  // driven. Throws InputError at `where` for more than ten million.
  static std::vector<double> placesOf(const Way& way, const std::vector<double>& knots, const Location& where);

  // The pose on the ground: position and heading of the pose, height, pitch and roll of the ground.
  Pose place(const Pose& pose, double at) const;
  // The share of the way that has no ground, where the heights around it are kept.
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

// The same of a single pose, which keeps its own pitch and roll on top. Throws InputError where there is no ground.
Pose onGround(const GroundOptions& options, const Pose& pose, const Ground& ground);

}  // namespace scanmill
