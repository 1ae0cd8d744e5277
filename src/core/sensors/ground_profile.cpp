#include "sensors/ground_profile.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "base/short_text.h"
#include "config/fields.h"

namespace scanmill {
namespace {

constexpr double kSmooth = 0.3;        // m of path before and behind a sample over which the profile is averaged,
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

// Returns where the wheels of a vehicle with this wheelbase and track (m) are, in the order of kWheels, at the height
// of the pose.
std::array<Vec3d, 4> wheelsAt(const std::array<double, 2>& size, const Pose& pose) {
  const double yaw = headingOf(pose.rotation);
  const Vec3d ahead = Vec3d{std::cos(yaw), std::sin(yaw), 0} * (size[0] / 2);
  const Vec3d left = Vec3d{-std::sin(yaw), std::cos(yaw), 0} * (size[1] / 2);
  const Vec3d& at = pose.translation;
  return {at + ahead + left, at + ahead + -left, at + -ahead + left, at + -ahead + -left};
}

// Returns the height and slopes of the plane that best fits the ground under the four wheels; nothing if more than one
// wheel has no ground. Without wheels, the plane is horizontal and touches the ground under the pose. `height` returns
// the height of the ground at a position in the world frame.
template <typename Height>
std::optional<GroundSample> standAt(const GroundOptions& options, const Pose& pose, const Height& height) {
  const Vec3d& at = pose.translation;
  if (!options.wheels) {
    const std::optional<double> z = height(at);
    return z ? std::optional<GroundSample>({*z, 0, 0}) : std::nullopt;
  }
  const std::array<Vec3d, 4> wheels = wheelsAt(*options.wheels, pose);
  std::array<double, 4> wheel{};  // m, heights of the ground, in the order of kWheels
  std::optional<std::size_t> hangs;
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const std::optional<double> z = height(wheels[i]);
    if (!z && hangs) return std::nullopt;
    if (z) {
      wheel[i] = *z;
    } else {
      hangs = i;
    }
  }
  // A wheel without ground is put into the plane of the other three wheels.
  if (hangs) wheel[*hangs] = wheel[*hangs ^ 1] + wheel[*hangs ^ 2] - wheel[*hangs ^ 3];
  return GroundSample{(wheel[0] + wheel[1] + wheel[2] + wheel[3]) / 4,
                      (wheel[0] + wheel[1] - wheel[2] - wheel[3]) / (2 * (*options.wheels)[0]),
                      (wheel[0] + wheel[2] - wheel[1] - wheel[3]) / (2 * (*options.wheels)[1])};
}

// Returns the rotation of a vehicle with heading `yaw` (rad) on a plane with the slopes `along` (ahead) and `left`.
Quat onSlope(double yaw, double along, double left) {
  const Vec3d x = normalized(Vec3d{1, 0, along});
  const Vec3d z = normalized(Vec3d{-along, -left, 1});
  return fromYawPitchRoll(yaw, 0, 0) * fromMatrix({x, cross(z, x), z});
}

}  // namespace

GroundOptions readGround(const Value& value) {
  GroundOptions options;
  options.where = value.where;
  if (value.kind == Value::Kind::Scalar && value.text == "drop") return options;
  if (value.kind != Value::Kind::Map) {
    throw InputError(value.where,
                     "ground must be `drop` or a map such as {height: 1.8, wheels: [2.7, 1.6], on: [road]}");
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
  std::vector<std::optional<GroundSample>> found(positions_.size());
  std::vector<double> driven(positions_.size(), 0.0);  // m driven up to each position
  std::optional<double> last;
  double lastAt = 0;  // m driven up to the latest sample that has ground
  Vec3d before = poseOnPath(0).translation;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const Pose pose = poseOnPath(positions_[i]);
    const Vec3d step = pose.translation - before;
    driven[i] = (i > 0 ? driven[i - 1] : 0) + std::hypot(step.x, step.y);
    before = pose.translation;
    const bool lost = !last || driven[i] - lastAt > kBareUntilLost;
    const auto height = [&](Vec3d point) {
      if (last) point.z = *last;
      const std::optional<double> z = last ? ground.near(point) : std::nullopt;
      return z || !lost ? z : ground.under(point);
    };
    found[i] = standAt(options, pose, height);
    if (found[i]) {
      last = found[i]->height;
      lastAt = driven[i];
    }
  }
  if (!last) {
    throw InputError(options.where,
                     fmt::format("no part of the path, which begins at {}, has ground above or below it: `scanmill "
                                 "info` of the scene prints its bounds (`start` moves recorded poses){}",
                                 shortPosition(poseOnPath(0).translation), options.wheels ? kWheelAdvice : ""));
  }
  const auto bare = std::count(found.begin(), found.end(), std::nullopt);
  bare_ = static_cast<double>(bare) / static_cast<double>(positions_.size());
  // A sample without ground becomes a copy of the sample before it. If no earlier sample has ground, it becomes a copy
  // of the first sample with ground.
  GroundSample known = **std::find_if(found.begin(), found.end(), [](const auto& s) { return s.has_value(); });
  for (const auto& sample : found) {
    if (sample) known = *sample;
    samples_.push_back({known.height + options.height, known.along, known.left});
  }
  for (int pass = 0; pass < 2; ++pass) samples_ = smoothed(samples_, driven);
}

std::vector<double> GroundProfile::samplePositions(const PoseOnPath& poseOnPath, const std::vector<double>& knots,
                                                   const Location& where) {
  std::vector<double> positions{knots.front()};
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const double from = knots[i - 1];
    const double span = knots[i] - from;
    const double metres = length(poseOnPath(knots[i]).translation - poseOnPath(from).translation);
    const double steps = std::max(std::ceil(metres / kSpacing), 1.0);
    if (static_cast<double>(positions.size()) + steps > static_cast<double>(kMostSamples)) {
      throw InputError(
          where, fmt::format("the path is too long: the ground is sampled every {:g} m, and at most {} times", kSpacing,
                             kMostSamples));
    }
    const auto count = static_cast<std::size_t>(steps);
    for (std::size_t k = 1; k < count; ++k) positions.push_back(from + span * static_cast<double>(k) / steps);
    positions.push_back(knots[i]);
  }
  return positions;
}

// Smooths each sample over its neighbours on the path, up to kSmooth before and behind the sample.
std::vector<GroundSample> GroundProfile::smoothed(const std::vector<GroundSample>& samples,
                                                  const std::vector<double>& driven) {
  std::vector<GroundSample> means;
  means.reserve(samples.size());
  const std::size_t last = samples.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    // Take the same number of samples on both sides, so that constant slopes are preserved even at the ends of the
    // path.
    std::size_t reach = 0;  // samples on each side
    while (reach < std::min({i, last - i, kMostSmoothed}) && driven[i] - driven[i - reach - 1] <= kSmooth &&
           driven[i + reach + 1] - driven[i] <= kSmooth) {
      ++reach;
    }
    // Fit a line by least squares and evaluate the line at the sample's position on the path: this preserves constant
    // slopes for any spacing of the samples.
    double sumD = 0;
    double sumDD = 0;
    GroundSample sum;
    GroundSample sumTimesD;  // sums of the values times their distances from the sample
    for (std::size_t k = i - reach; k <= i + reach; ++k) {
      const GroundSample& s = samples[k];
      const double d = driven[k] - driven[i];
      sumD += d;
      sumDD += d * d;
      sum = {sum.height + s.height, sum.along + s.along, sum.left + s.left};
      sumTimesD = {sumTimesD.height + d * s.height, sumTimesD.along + d * s.along, sumTimesD.left + d * s.left};
    }
    const auto count = static_cast<double>(2 * reach + 1);
    const double spread = count * sumDD - sumD * sumD;
    const auto fitted = [&](double values, double by) {
      return spread > 1e-9 ? (values * sumDD - by * sumD) / spread : values / count;
    };
    means.push_back(
        {fitted(sum.height, sumTimesD.height), fitted(sum.along, sumTimesD.along), fitted(sum.left, sumTimesD.left)});
  }
  return means;
}

Pose GroundProfile::place(const Pose& pose, double at) const {
  const auto later = std::upper_bound(positions_.begin(), positions_.end(), at);
  const auto behind = static_cast<std::size_t>(later - positions_.begin());
  const std::size_t j = std::min(behind, positions_.size() - 1);
  const std::size_t i = behind == 0 ? 0 : behind - 1;
  const GroundSample& a = samples_[i];
  const GroundSample& b = samples_[j];
  const double u = i == j ? 0 : std::clamp((at - positions_[i]) / (positions_[j] - positions_[i]), 0.0, 1.0);
  const auto mix = [&](double from, double to) { return from + (to - from) * u; };
  Pose placed{onSlope(headingOf(pose.rotation), mix(a.along, b.along), mix(a.left, b.left)), pose.translation};
  placed.translation.z = mix(a.height, b.height);
  return placed;
}

Pose onGround(const GroundOptions& options, const Pose& pose, const Ground& ground) {
  const std::optional<GroundSample> stand =
      standAt(options, pose, [&](const Vec3d& point) { return ground.under(point); });
  const Vec3d& at = pose.translation;
  if (!stand) {
    std::string text = fmt::format("the pose at [{:g}, {:g}, {:g}] has no ground above or below it", at.x, at.y, at.z);
    const std::array<Vec3d, 4> wheels = options.wheels ? wheelsAt(*options.wheels, pose) : std::array<Vec3d, 4>{};
    for (std::size_t i = 0; options.wheels && i < wheels.size(); ++i) {
      if (ground.under(wheels[i])) continue;
      text += fmt::format(", at its {} wheel [{:.6g}, {:.6g}]", kWheels[i], wheels[i].x, wheels[i].y);
    }
    throw InputError(options.where, text + (options.wheels ? kWheelAdvice : ""));
  }
  const double yaw = headingOf(pose.rotation);
  const Quat own = inverse(Pose{fromYawPitchRoll(yaw, 0, 0), {}}).rotation * pose.rotation;
  return {onSlope(yaw, stand->along, stand->left) * own, {at.x, at.y, stand->height + options.height}};
}

}  // namespace scanmill
