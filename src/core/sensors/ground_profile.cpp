#include "sensors/ground_profile.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/short_text.h"
#include "config/fields.h"

namespace scanmill {
namespace {

constexpr double kSmooth = 0.3;        // m of path before and after a sample over which the profile is averaged,
                                       // since springs and tyres smooth it
constexpr double kBareUntilLost = 10;  // m of path without ground, after which ground of any height is accepted
constexpr double kSpacing = 0.1;       // m, largest distance between samples
constexpr std::size_t kMostSamples = 10'000'000;
constexpr std::size_t kMostSmoothed = 20;  // largest number of samples averaged on each side, for parts of the path
                                           // where the vehicle hardly moves

constexpr const char* kWheelAdvice =
    "; three of a vehicle's four wheels need ground of the classes of `on`; `wheels: none` needs it below the origin "
    "alone";
constexpr std::array<std::string_view, 4> kWheels{"front left", "front right", "rear left", "rear right"};

// Returns the positions of the wheels in the order of kWheels, at the pose's height. `size`: wheelbase and track (m).
std::array<Vec3d, 4> wheelsAt(const std::array<double, 2>& size, const Pose& pose) {
  const double yaw = headingOf(pose.rotation);
  const Vec3d ahead = Vec3d{std::cos(yaw), std::sin(yaw), 0} * (size[0] / 2);
  const Vec3d left = Vec3d{-std::sin(yaw), std::cos(yaw), 0} * (size[1] / 2);
  const Vec3d& center = pose.translation;
  return {center + ahead + left, center + ahead + -left, center + -ahead + left, center + -ahead + -left};
}

// Returns the height and slopes of the plane that best fits the ground under the four wheels; nothing if more than one
// wheel has no ground. Without wheels, the plane is horizontal and touches the ground under the pose. `height` returns
// the height of the ground at a position in the world frame.
template <typename Height>
std::optional<GroundSample> sampleAt(const GroundOptions& options, const Pose& pose, const Height& height) {
  if (!options.wheels) {
    const std::optional<double> z = height(pose.translation);
    return z ? std::optional(GroundSample{.height = *z}) : std::nullopt;
  }
  const std::array<Vec3d, 4> wheels = wheelsAt(*options.wheels, pose);
  std::array<double, 4> z{};           // m, heights of the ground, in the order of kWheels
  std::optional<std::size_t> hanging;  // index of the wheel that has no ground
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const std::optional<double> ground = height(wheels[i]);
    if (!ground && hanging) return std::nullopt;
    if (!ground) hanging = i;
    z[i] = ground.value_or(0);
  }
  // A wheel without ground is put into the plane of the other three wheels. In the order of kWheels, index ^ 1 is the
  // other wheel of the axle, index ^ 2 the other wheel on the same side, and index ^ 3 the wheel diagonally opposite.
  if (hanging) z[*hanging] = z[*hanging ^ 1] + z[*hanging ^ 2] - z[*hanging ^ 3];
  const auto [wheelbase, track] = *options.wheels;
  return GroundSample{.height = (z[0] + z[1] + z[2] + z[3]) / 4,
                      .along = (z[0] + z[1] - z[2] - z[3]) / (2 * wheelbase),
                      .left = (z[0] + z[2] - z[1] - z[3]) / (2 * track)};
}

// Returns the rotation of a vehicle with heading `yaw` (rad) on a plane with the slopes `along` (ahead) and `left`.
Quat onSlope(double yaw, double along, double left) {
  const Vec3d x = normalized(Vec3d{1, 0, along});
  const Vec3d z = normalized(Vec3d{-along, -left, 1});
  return fromYawPitchRoll(yaw, 0, 0) * fromMatrix({x, cross(z, x), z});
}

// Fits a line by least squares to the samples middle - reach to middle + reach over the distance `driven` (m along the
// path, by sample). Returns the line's values at the sample `middle`. A line preserves constant slopes for any spacing.
GroundSample fitAt(std::size_t middle, std::size_t reach, const std::vector<GroundSample>& samples,
                   const std::vector<double>& driven) {
  double sumD = 0, sumDD = 0;   // sums of the distances from the middle sample (m) and of their squares
  GroundSample sum, sumTimesD;  // sums of the values, and of the values times the distances
  for (std::size_t k = middle - reach; k <= middle + reach; ++k) {
    const GroundSample& s = samples[k];
    const double d = driven[k] - driven[middle];
    sumD += d;
    sumDD += d * d;
    sum = {sum.height + s.height, sum.along + s.along, sum.left + s.left};
    sumTimesD = {sumTimesD.height + d * s.height, sumTimesD.along + d * s.along, sumTimesD.left + d * s.left};
  }
  const auto count = static_cast<double>(2 * reach + 1);
  const double spread = count * sumDD - sumD * sumD;
  const auto fitted = [&](double valueSum, double valueTimesDSum) {
    return spread > 1e-9 ? (valueSum * sumDD - valueTimesDSum * sumD) / spread : valueSum / count;
  };
  return {fitted(sum.height, sumTimesD.height), fitted(sum.along, sumTimesD.along), fitted(sum.left, sumTimesD.left)};
}

// Smooths each sample over up to kMostSmoothed neighbours on each side within kSmooth. `driven`: m along the path.
std::vector<GroundSample> smoothed(const std::vector<GroundSample>& samples, const std::vector<double>& driven) {
  std::vector<GroundSample> means;
  means.reserve(samples.size());
  const std::size_t last = samples.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    // Take equally many samples on both sides, so that constant slopes are preserved even at the path's ends.
    std::size_t reach = 0;  // samples on each side
    while (reach < std::min({i, last - i, kMostSmoothed}) && driven[i] - driven[i - reach - 1] <= kSmooth &&
           driven[i + reach + 1] - driven[i] <= kSmooth) {
      ++reach;
    }
    means.push_back(fitAt(i, reach, samples, driven));
  }
  return means;
}

}  // namespace

std::optional<GroundOptions> readGround(const Value& value) {
  GroundOptions options;
  options.where = value.where;
  if (value.kind == Value::Kind::Scalar && value.text == "none") return std::nullopt;
  if (value.kind == Value::Kind::Scalar && value.text == "drop") return options;
  if (value.kind != Value::Kind::Map) {
    throw InputError(value.where,
                     "ground must be `drop`, `none` or a map such as {height: 1.8, wheels: [2.7, 1.6], on: [road]}");
  }
  Fields f(value, "ground");
  f.also({"height", "wheels", "on"}).finish();
  options.height = f.number("height", {-1000, 1000}, 0);
  if (const Value* wheels = f.find("wheels")) {
    if (wheels->kind == Value::Kind::Scalar && wheels->text == "none") {
      options.wheels.reset();
    } else {
      const std::vector<double> sizes = f.numbers("wheels", {0.05, 50});
      if (sizes.size() != 2) {
        throw InputError(wheels->where,
                         "wheels must be [wheelbase, track] in m, or none, which keeps the vehicle upright");
      }
      options.wheels = {{sizes[0], sizes[1]}};
    }
  }
  options.classes = f.texts("on");
  return options;
}

GroundProfile::GroundProfile(const GroundOptions& options, const PoseOnPath& poseOnPath, std::vector<double> positions,
                             const Ground& ground)
    : positions_(std::move(positions)) {
  std::vector<std::optional<GroundSample>> samples(positions_.size());  // nothing: no ground
  std::vector<double> driven(positions_.size(), 0.0);                   // m driven up to each position
  std::optional<double> lastHeight;  // m, height of the latest sample that has ground
  double lastDriven = 0;             // m driven up to this sample
  Vec3d previousPoint = poseOnPath(0).translation;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const Pose pose = poseOnPath(positions_[i]);
    const Vec3d step = pose.translation - previousPoint;
    driven[i] = (i > 0 ? driven[i - 1] : 0) + std::hypot(step.x, step.y);
    previousPoint = pose.translation;
    const bool acceptAnyHeight = !lastHeight || driven[i] - lastDriven > kBareUntilLost;
    const auto height = [&](Vec3d point) {
      point.z = lastHeight.value_or(point.z);
      const std::optional<double> z = lastHeight ? ground.near(point) : std::nullopt;
      return z || !acceptAnyHeight ? z : ground.under(point);
    };
    samples[i] = sampleAt(options, pose, height);
    if (!samples[i]) continue;
    lastHeight = samples[i]->height;
    lastDriven = driven[i];
  }
  if (!lastHeight && options.onlyIfAtGround) {
    bareFraction_ = 1;
    return;
  }
  if (!lastHeight) {
    throw InputError(options.where,
                     "no part of the path, which begins at {}, has ground above or below it: `scanmill "
                     "info` of the scene prints its bounds (`start` moves recorded poses){}",
                     shortPosition(poseOnPath(0).translation), options.wheels ? kWheelAdvice : "");
  }
  const auto bareSamples = std::count(samples.begin(), samples.end(), std::nullopt);
  bareFraction_ = static_cast<double>(bareSamples) / static_cast<double>(positions_.size());
  // A sample without ground becomes a copy of the sample before it. If no earlier sample has ground, it becomes a copy
  // of the first sample with ground.
  GroundSample filled = **std::ranges::find_if(samples, [](const auto& sample) { return sample.has_value(); });
  for (const auto& sample : samples) {
    filled = sample.value_or(filled);
    samples_.push_back({filled.height + options.height, filled.along, filled.left});
  }
  for (int pass = 0; pass < 2; ++pass) samples_ = smoothed(samples_, driven);
}

std::vector<double> GroundProfile::samplePositions(const PoseOnPath& poseOnPath, const std::vector<double>& knots,
                                                   const Location& where) {
  std::vector<double> positions{knots.front()};
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const double from = knots[i - 1];
    const double span = knots[i] - from;  // m or s, like the positions
    const double metres = length(poseOnPath(knots[i]).translation - poseOnPath(from).translation);
    const double steps = std::max(std::ceil(metres / kSpacing), 1.0);
    if (static_cast<double>(positions.size()) + steps > static_cast<double>(kMostSamples)) {
      throw InputError(where, "the path is too long: the ground is sampled every {:g} m, and at most {} times",
                       kSpacing, kMostSamples);
    }
    const auto count = static_cast<std::size_t>(steps);
    for (std::size_t k = 1; k < count; ++k) positions.push_back(from + span * static_cast<double>(k) / steps);
    positions.push_back(knots[i]);
  }
  return positions;
}

Pose GroundProfile::place(const Pose& pose, double position) const {
  // Interpolate between the samples i and j around the position; both are the same sample at the path's ends.
  const auto next = static_cast<std::size_t>(std::ranges::upper_bound(positions_, position) - positions_.begin());
  const std::size_t j = std::min(next, positions_.size() - 1);
  const std::size_t i = next == 0 ? 0 : next - 1;
  const GroundSample& a = samples_[i];
  const GroundSample& b = samples_[j];
  const double u = i == j ? 0 : std::clamp((position - positions_[i]) / (positions_[j] - positions_[i]), 0.0, 1.0);
  const auto mix = [&](double from, double to) { return from + (to - from) * u; };
  Pose placed{onSlope(headingOf(pose.rotation), mix(a.along, b.along), mix(a.left, b.left)), pose.translation};
  placed.translation.z = mix(a.height, b.height);
  return placed;
}

Pose onGround(const GroundOptions& options, const Pose& pose, const Ground& ground) {
  const std::optional<GroundSample> sample =
      sampleAt(options, pose, [&](const Vec3d& point) { return ground.under(point); });
  const auto [x, y, z] = pose.translation;
  if (!sample) {
    std::string text = fmt::format("the pose at [{:g}, {:g}, {:g}] has no ground above or below it", x, y, z);
    const std::array<Vec3d, 4> wheels = options.wheels ? wheelsAt(*options.wheels, pose) : std::array<Vec3d, 4>{};
    for (std::size_t i = 0; options.wheels && i < wheels.size(); ++i) {
      if (ground.under(wheels[i])) continue;
      text += fmt::format(", at its {} wheel [{:.6g}, {:.6g}]", kWheels[i], wheels[i].x, wheels[i].y);
    }
    throw InputError(options.where, text + (options.wheels ? kWheelAdvice : ""));
  }
  const double yaw = headingOf(pose.rotation);
  const Quat pitchAndRoll = inverse(Pose{fromYawPitchRoll(yaw, 0, 0), {}}).rotation * pose.rotation;
  return {onSlope(yaw, sample->along, sample->left) * pitchAndRoll, {x, y, sample->height + options.height}};
}

}  // namespace scanmill
