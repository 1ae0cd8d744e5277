#include "sensors/ground_profile.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/short_text.h"
#include "config/fields.h"

namespace scanmill {
namespace {

constexpr double kSmooth = 0.3;  // m of way, over which springs and tyres even the ground out

double yawOf(const Pose& pose) {
  const Vec3d x = toMatrix(pose.rotation).x;
  return std::atan2(x.y, x.x);
}

struct Stand {
  double height, along, left;
};

// The plane nearest to what the four wheels stand on; `height` finds the ground at a place of the world.
template <typename Height>
std::optional<Stand> standAt(const GroundOptions& options, const Pose& pose, const Height& height) {
  const Vec3d& at = pose.translation;
  if (!options.wheels) {
    const std::optional<double> z = height(at);
    return z ? std::optional<Stand>({*z, 0, 0}) : std::nullopt;
  }
  const double yaw = yawOf(pose);
  const Vec3d ahead = Vec3d{std::cos(yaw), std::sin(yaw), 0} * ((*options.wheels)[0] / 2);
  const Vec3d left = Vec3d{-std::sin(yaw), std::cos(yaw), 0} * ((*options.wheels)[1] / 2);
  std::array<double, 4> wheel{};  // front left, front right, rear left, rear right
  for (int i = 0; i < 4; ++i) {
    const std::optional<double> z = height(at + (i < 2 ? ahead : -ahead) + (i % 2 == 0 ? left : -left));
    if (!z) return std::nullopt;
    wheel[i] = *z;
  }
  return Stand{(wheel[0] + wheel[1] + wheel[2] + wheel[3]) / 4,
               (wheel[0] + wheel[1] - wheel[2] - wheel[3]) / (2 * (*options.wheels)[0]),
               (wheel[0] + wheel[2] - wheel[1] - wheel[3]) / (2 * (*options.wheels)[1])};
}

// Heading `yaw` over ground, on a plane of these slopes.
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
    throw InputError(value.where, "ground must be `drop` or such as {height: 1.8, wheels: [2.7, 1.6], on: [road]}");
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
        throw InputError(wheels->where, "wheels must be [wheelbase, track] in m, or none, which keeps it upright");
      }
      options.wheels = {{sizes[0], sizes[1]}};
    }
  }
  options.classes = f.texts("on");
  return options;
}

GroundProfile::GroundProfile(const GroundOptions& options, const Way& way, double end, double step,
                             const Ground& ground)
    : step_(step) {
  const auto count = static_cast<std::size_t>(std::ceil(end / step)) + 1;
  std::vector<std::optional<Sample>> found(count);
  std::optional<double> last;
  std::size_t bare = 0;
  double driven = 0;
  Vec3d before = way(0).translation;
  for (std::size_t i = 0; i < count; ++i) {
    const Pose pose = way(std::min(static_cast<double>(i) * step, end));
    driven += length(pose.translation - before);
    before = pose.translation;
    const auto height = [&](Vec3d place) {
      if (!last) return ground.under(place);
      place.z = *last;
      const std::optional<double> z = ground.near(place);
      return z ? z : ground.under(place);
    };
    if (const std::optional<Stand> stand = standAt(options, pose, height)) {
      found[i] = Sample{stand->height, stand->along, stand->left};
      last = stand->height;
    } else {
      ++bare;
    }
  }
  if (!last)
    throw InputError(options.where,
                     fmt::format("there is no ground above or below the whole way, which begins at {}: `scanmill "
                                 "info` of the scene tells where it lies, `start` moves recorded poses",
                                 shortPlace(way(0).translation)));
  bare_ = static_cast<double>(bare) / static_cast<double>(count);
  // Where there is none: as before, or at the start as behind.
  Sample known = **std::find_if(found.begin(), found.end(), [](const auto& s) { return s.has_value(); });
  std::vector<Sample> rough;
  for (const auto& sample : found) {
    if (sample) known = *sample;
    rough.push_back({known.height + options.height, known.along, known.left});
  }
  const double metres = driven / static_cast<double>(std::max<std::size_t>(count - 1, 1));
  samples_ = std::move(rough);
  for (int pass = 0; pass < 2; ++pass) samples_ = evened(samples_, static_cast<std::size_t>(kSmooth / (metres + 1e-3)));
}

// Means over so many samples before and behind each.
std::vector<GroundProfile::Sample> GroundProfile::evened(const std::vector<Sample>& samples, std::size_t reach) {
  std::vector<Sample> means;
  means.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    // As many on both sides, so that slopes stay what they are at the ends too.
    const std::size_t own = std::min({reach, i, samples.size() - 1 - i});
    Sample sum;
    for (std::size_t k = i - own; k <= i + own; ++k) {
      sum.height += samples[k].height;
      sum.along += samples[k].along;
      sum.left += samples[k].left;
    }
    const double share = 1 / static_cast<double>(2 * own + 1);
    means.push_back({sum.height * share, sum.along * share, sum.left * share});
  }
  return means;
}

Pose GroundProfile::place(const Pose& pose, double at) const {
  const double steps = std::clamp(at / step_, 0.0, static_cast<double>(samples_.size() - 1));
  const auto i = static_cast<std::size_t>(steps);
  const Sample& a = samples_[i];
  const Sample& b = samples_[std::min(i + 1, samples_.size() - 1)];
  const double u = steps - static_cast<double>(i);
  const auto mix = [&](double from, double to) { return from + (to - from) * u; };
  Pose placed{onSlope(yawOf(pose), mix(a.along, b.along), mix(a.left, b.left)), pose.translation};
  placed.translation.z = mix(a.height, b.height);
  return placed;
}

Pose onGround(const GroundOptions& options, const Pose& pose, const Ground& ground) {
  const std::optional<Stand> stand = standAt(options, pose, [&](const Vec3d& place) { return ground.under(place); });
  const Vec3d& at = pose.translation;
  if (!stand) {
    throw InputError(options.where,
                     fmt::format("there is no ground above or below the pose at [{:g}, {:g}, {:g}]", at.x, at.y, at.z));
  }
  const double yaw = yawOf(pose);
  const Quat own = inverse(Pose{fromYawPitchRoll(yaw, 0, 0), {}}).rotation * pose.rotation;
  return {onSlope(yaw, stand->along, stand->left) * own, {at.x, at.y, stand->height + options.height}};
}

}  // namespace scanmill
