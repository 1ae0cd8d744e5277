#include "report/dataset/anomalies.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "report/page/page.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {

namespace {

using Sides = std::array<double, 3>;  // length, width, height (m)

Sides sidesOf(const SeenSize& size) {
  return {size.length, size.width, size.height};
}

// Returns the quantile `share` (0 to 1) of a sorted list, linearly interpolated.
double quantileOf(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

// The usual sizes of a class: quantiles of the length, width and height of its objects. The fraction `spared` of the
// smallest and of the largest values is ignored, since their labels may be wrong.
struct UsualSides {
  Sides low{}, middle{}, high{};

  UsualSides(const std::vector<Sides>& things, double spared) {
    for (std::size_t side = 0; side < 3; ++side) {
      std::vector<double> values;
      values.reserve(things.size());
      for (const Sides& t : things) values.push_back(t[side]);
      std::ranges::sort(values);
      low[side] = quantileOf(values, spared);
      middle[side] = quantileOf(values, 0.5);
      high[side] = quantileOf(values, 1 - spared);
    }
  }

  // True if a side is outside of the usual range by more than the factor and by more than the length (m).
  bool isBeyond(const Sides& sides, std::size_t side, double factor, double metres) const {
    return sides[side] < std::min(low[side] / factor, low[side] - metres) ||
           sides[side] > std::max(high[side] * factor, high[side] + metres);
  }
  int countBeyond(const Sides& sides, double factor, double metres) const {
    int count = 0;
    for (std::size_t side = 0; side < 3; ++side) count += isBeyond(sides, side, factor, metres) ? 1 : 0;
    return count;
  }
  // True if objects can be recognised by this size. False for classes of varied objects, such as boxes and barrows, and
  // for tiny objects.
  bool tell() const {
    // Largest ratio and difference (m) of `high` and `low`; least length of usual objects (m).
    constexpr double kMostRatio = 2.5, kMostDifference = 0.5, kLeastLength = 0.4;
    if (middle[0] < kLeastLength) return false;
    for (std::size_t side = 0; side < 3; ++side) {
      if (high[side] > kMostRatio * low[side] && high[side] - low[side] > kMostDifference) return false;
    }
    return true;
  }
  double distanceTo(const Sides& sides) const {
    constexpr double kLeast = 0.05;  // smaller lengths are treated as this length (m)
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

  // True if the class has few instances and their ids are probably an error, since most points of the class have no id
  // or the ontology does not mark the class as things. False for classes that usually share objects with another class,
  // such as trunks.
  bool isUncounted(const ClassSummary& c) const {
    constexpr std::size_t kFew = 3;
    constexpr double kFewShare = 0.02;  // a class with at most kFew objects or this fraction of all counts as rare
    const auto own = thingsOf_.find(c.id);
    if (own == thingsOf_.end() || parts_.contains(c.id)) return false;
    const auto share = static_cast<std::size_t>(kFewShare * static_cast<double>(sum_.things.size()));
    if (own->second.size() > std::max(kFew, share)) return false;
    std::uint64_t points = 0;
    for (const std::size_t i : own->second) points += sum_.things[i].points;
    // If the ontology marks classes as things, instances of a class without this mark are suspicious.
    return c.pointsWithoutId > points || (counts_ && c.known && !c.thing);
  }

  void sizes() {
    constexpr std::size_t kFewestAlike = 5;  // least number of objects from which the usual size of a class is computed
    // Two of an object's three sides must be outside of its class's usual range, since one side may be too short
    // because parts of the object are hidden.
    constexpr double kOwnSpared = 0.1, kBeyondFactor = 1.3, kBeyondMetres = 0.3;
    constexpr int kSidesBeyond = 2;
    // All sides of the object must be within the usual range of another class, the class that the object resembles,
    // extended by this factor or this length (m).
    constexpr double kOtherSpared = 0.05, kWithinFactor = 1.15, kWithinMetres = 0.1;
    std::map<std::uint16_t, std::vector<std::size_t>> wellSeen;
    for (const auto& [id, things] : thingsOf_) {
      if (id == 0 || uncounted_.contains(id)) continue;
      for (const std::size_t i : things) {
        // Objects with points of several classes are not used, since their visible size depends on which part is
        // visible: the tree or its trunk.
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

  // Returns the sizes of all objects except that at index k.
  std::vector<Sides> sidesWithout(const std::vector<std::size_t>& things, std::size_t k) const {
    std::vector<Sides> sides;
    for (std::size_t i = 0; i < things.size(); ++i) {
      if (i != k) sides.push_back(sidesOf(*sum_.things[things[i]].size));
    }
    return sides;
  }

  const DatasetSummary& sum_;
  // Instances, as (sequence, id), about which there is a MixedInstance warning already.
  std::set<std::pair<std::string, std::uint32_t>> mixed_;
  std::set<std::uint16_t> parts_;  // ids of classes that usually share objects with another class
  std::map<std::uint16_t, std::vector<std::size_t>> thingsOf_;
  bool counts_ = false;  // true: at least one class with instances is a thing in the ontology
  std::set<std::uint16_t> uncounted_;
  std::vector<Anomaly> anomalies_;
};

// Returns a camera that looks at the box from the sensor's side, slightly from above. It is near enough for the box to
// fill much of the picture.
OrbitCamera cameraOn(const Box& box) {
  // Pitch (degrees); factor for the distance that frames the box; least distance (m).
  constexpr double kPitch = 20, kRoom = 2, kLeastDistance = 4;
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
