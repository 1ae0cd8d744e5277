#include "report/dataset/anomalies.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "report/page/page.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {

namespace {

using Sides = std::array<double, 3>;  // length, width, height (m)

Sides sidesOf(const SeenSize& size) {
  return {size.length, size.width, size.height};
}

// Interpolates linearly between the values of a sorted list.
double quantileOf(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

// The usual sizes of a class, without its extremes, some of which may be mistakes themselves.
struct UsualSides {
  Sides low{}, middle{}, high{};

  UsualSides(const std::vector<Sides>& things, double spared) {
    for (std::size_t side = 0; side < 3; ++side) {
      std::vector<double> values;
      values.reserve(things.size());
      for (const Sides& t : things) values.push_back(t[side]);
      std::sort(values.begin(), values.end());
      low[side] = quantileOf(values, spared);
      middle[side] = quantileOf(values, 0.5);
      high[side] = quantileOf(values, 1 - spared);
    }
  }

  // True if a side lies beyond the range by a factor and by a length (m).
  bool isBeyond(const Sides& sides, std::size_t side, double factor, double metres) const {
    return sides[side] < std::min(low[side] / factor, low[side] - metres) ||
           sides[side] > std::max(high[side] * factor, high[side] + metres);
  }
  int countBeyond(const Sides& sides, double factor, double metres) const {
    int count = 0;
    for (std::size_t side = 0; side < 3; ++side) count += isBeyond(sides, side, factor, metres) ? 1 : 0;
    return count;
  }
  // True if the size is characteristic: not for a class of varied objects such as boxes and barrows, nor for tiny ones.
  bool tell() const {
    constexpr double kMostRatio = 2.5, kMostDifference = 0.5, kLeastLength = 0.4;  // m
    if (middle[0] < kLeastLength) return false;
    for (std::size_t side = 0; side < 3; ++side) {
      if (high[side] > kMostRatio * low[side] && high[side] - low[side] > kMostDifference) return false;
    }
    return true;
  }
  double distanceTo(const Sides& sides) const {
    constexpr double kLeast = 0.05;  // m: smaller lengths count as equal
    double sum = 0;
    for (std::size_t side = 0; side < 3; ++side) {
      sum += std::abs(std::log(std::max(sides[side], kLeast) / std::max(middle[side], kLeast)));
    }
    return sum;
  }
};

class AnomalySearch {
 public:
  explicit AnomalySearch(const DatasetSummary& summary) : sum_(summary) {
    for (const MixedInstance& m : sum_.mixed) {
      if (!m.usual) {
        mixed_.insert({m.sequence, m.id});
        continue;
      }
      for (const auto& entry : m.pointsOfClass) parts_.insert(entry.first);
    }
    for (std::size_t i = 0; i < sum_.things.size(); ++i) {
      if (isPlain(sum_.things[i])) thingsOf_[sum_.things[i].mostClass].push_back(i);
    }
    for (const ClassSummary& c : sum_.classes) counts_ = counts_ || (c.thing && c.objects > 0);
  }

  std::vector<Anomaly> all() {
    for (const ClassSummary& c : sum_.classes) {
      if (isUncounted(c)) uncounted_.insert(c.id);
    }
    for (const std::uint16_t id : uncounted_) {
      for (const std::size_t thing : thingsOf_[id]) anomalies_.push_back({thing});
    }
    sizes();
    return std::move(anomalies_);
  }

 private:
  bool isPlain(const ThingSummary& thing) const { return !mixed_.contains({thing.sequence, thing.id}); }

  // True if the points of a class have no ids, except for a few objects. Classes of parts of objects do not count.
  bool isUncounted(const ClassSummary& c) const {
    constexpr std::size_t kFew = 3;
    constexpr double kFewShare = 0.02;  // share of all instances
    const auto own = thingsOf_.find(c.id);
    if (own == thingsOf_.end() || parts_.contains(c.id)) return false;
    const auto share = static_cast<std::size_t>(kFewShare * static_cast<double>(sum_.things.size()));
    if (own->second.size() > std::max(kFew, share)) return false;
    std::uint64_t points = 0;
    for (const std::size_t i : own->second) points += sum_.things[i].points;
    // If the ontology marks classes as things, a class without the mark is not meant to have ids.
    return c.pointsWithoutId > points || (counts_ && c.known && !c.thing);
  }

  void sizes() {
    constexpr std::size_t kFewestAlike = 5;  // objects that define a size
    // An object must leave its own class's usual range in two of its three sides, since parts of it may be hidden.
    constexpr double kOwnSpared = 0.1, kBeyondFactor = 1.3, kBeyondMetres = 0.3;
    constexpr int kSidesBeyond = 2;
    constexpr double kOtherSpared = 0.05, kWithinFactor = 1.15, kWithinMetres = 0.1;  // within the other class's range
    std::map<std::uint16_t, std::vector<std::size_t>> wellSeen;
    for (const auto& [id, things] : thingsOf_) {
      if (id == 0 || uncounted_.contains(id)) continue;
      for (const std::size_t i : things) {
        // Only objects of one class: of a tree with its trunk, scans show sometimes one, sometimes the other.
        if (sum_.things[i].size && sum_.things[i].pointsOfClass.size() == 1) wellSeen[id].push_back(i);
      }
    }
    std::map<std::uint16_t, UsualSides> usual;
    for (const auto& [id, things] : wellSeen) {
      if (things.size() < kFewestAlike) continue;
      const UsualSides sides(sidesWithout(things, things.size()), kOtherSpared);
      if (sides.tell()) usual.emplace(id, sides);
    }
    for (const auto& [id, things] : wellSeen) {
      if (things.size() <= kFewestAlike) continue;
      for (std::size_t k = 0; k < things.size(); ++k) {
        const Sides sides = sidesOf(*sum_.things[things[k]].size);
        const UsualSides own(sidesWithout(things, k), kOwnSpared);
        if (own.countBeyond(sides, kBeyondFactor, kBeyondMetres) < kSidesBeyond) continue;
        Anomaly anomaly{things[k]};
        double nearest = 0;
        for (const auto& [other, range] : usual) {
          if (other == id || range.countBeyond(sides, kWithinFactor, kWithinMetres) > 0) continue;
          const double distance = range.distanceTo(sides);
          if (anomaly.like && distance >= nearest) continue;
          nearest = distance;
          anomaly.like = other;
          anomaly.alike = wellSeen[other].size();
        }
        if (anomaly.like) anomalies_.push_back(anomaly);
      }
    }
  }

  // Returns the sizes of all objects but the k-th.
  std::vector<Sides> sidesWithout(const std::vector<std::size_t>& things, std::size_t k) const {
    std::vector<Sides> sides;
    for (std::size_t i = 0; i < things.size(); ++i) {
      if (i != k) sides.push_back(sidesOf(*sum_.things[things[i]].size));
    }
    return sides;
  }

  const DatasetSummary& sum_;
  std::set<std::pair<std::string, std::uint32_t>> mixed_;  // reported by another warning
  std::set<std::uint16_t> parts_;                          // classes of parts of other classes' objects
  std::map<std::uint16_t, std::vector<std::size_t>> thingsOf_;
  bool counts_ = false;  // the ontology marks classes as things
  std::set<std::uint16_t> uncounted_;
  std::vector<Anomaly> anomalies_;
};

// Returns a camera on the sensor's side of the box, a little above, and near enough for it to fill much of the picture.
OrbitCamera cameraOn(const Box& box) {
  constexpr double kPitch = 20, kRoom = 2, kLeastDistance = 4;  // deg, m
  const auto tenths = [](double v) { return std::round(v * 10) / 10 + 0.0; };
  OrbitCamera camera;
  const Vec3d center = box.center();
  camera.yaw = radians(std::round(degrees(std::atan2(center.y, center.x))) + 0.0);
  camera.pitch = radians(kPitch);
  camera.frame(box);
  camera.distance = tenths(std::max(kRoom * camera.distance, kLeastDistance));
  camera.target = {tenths(center.x), tenths(center.y), tenths(center.z)};
  return camera;
}

}  // namespace

std::vector<Anomaly> findAnomalies(const DatasetSummary& summary) {
  return AnomalySearch(summary).all();
}

std::string viewCommand(const std::filesystem::path& folder, const ThingSummary& thing, bool severalSensors) {
  return fmt::format("scanmill view {} --sample {}{} --camera={} --instance {}", shellWord(folder.string()),
                     shellWord(thing.bestSample), severalSensors ? " --sensor " + shellWord(thing.bestSensor) : "",
                     cameraOn(thing.bestBox).text(), thing.id);
}

}  // namespace scanmill
