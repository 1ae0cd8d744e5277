#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/instruction_sets.h"
#include "sense/returns.h"

namespace scanmill {

namespace {

constexpr float kBelowOne = 0.99999994f;  // the largest float below 1: upper bound of `share` if an echo has two
                                          // classes

// A ray with a hit.
struct HitRay {
  float range;        // m
  std::uint32_t ray;  // index in Hits
  double power;       // the ray's contribution to an echo
};

constexpr std::size_t kGroup = 64;            // number of beams whose echoes are computed together
constexpr std::uint32_t kMostGroupRays = 19;  // largest number of rays per beam in a group

// A group of beams whose echoes are computed together. Each beam forms one echo; all beams have equally many rays.
struct BeamGroup {
  template <class T>
  using PerBeam = std::array<T, kGroup>;

  std::uint32_t rays = 0;
  std::size_t count = 0;
  PerBeam<std::size_t> echo;         // index in the list of echoes
  PerBeam<std::uint32_t> first;      // the beam's first ray; the others follow
  PerBeam<std::uint32_t> strongest;  // index of the ray with the most power, the first among equals
  PerBeam<float> power, range, spread;
  std::array<PerBeam<float>, kMostGroupRays> ranges;  // by ray
  std::array<PerBeam<float>, kMostGroupRays> powers;
};

// Computes power, range, spread and the strongest ray of each beam from `ranges` and `powers`. Uses the same operations
// as EchoFinder::echoOf(), so that both functions give the same result for a beam. Computes all kGroup beams, also
// those from BeamGroup::count on, so that the loops have a fixed length and are vectorised.
SCANMILL_BEST_INSTRUCTIONS void computeEchoes(BeamGroup& group) {
  BeamGroup::PerBeam<double> totalPower{}, weightedSum{}, unweightedSum{}, squareSum{};
  BeamGroup::PerBeam<float> largestPower;
  largestPower.fill(-1);
  group.strongest.fill(0);
  for (std::uint32_t ray = 0; ray < group.rays; ++ray) {
    for (std::size_t beam = 0; beam < kGroup; ++beam) {
      const double power = group.powers[ray][beam];
      const double behindFirst = group.ranges[ray][beam] - double{group.ranges[0][beam]};
      totalPower[beam] += power;
      weightedSum[beam] += power * behindFirst;
      unweightedSum[beam] += behindFirst;
      group.strongest[beam] = group.powers[ray][beam] > largestPower[beam] ? ray : group.strongest[beam];
      largestPower[beam] = group.powers[ray][beam] > largestPower[beam] ? group.powers[ray][beam] : largestPower[beam];
    }
  }
  BeamGroup::PerBeam<double> mean;
  const double rayCount = group.rays;
  for (std::size_t beam = 0; beam < kGroup; ++beam) {
    const bool powered = totalPower[beam] > 0;
    mean[beam] = group.ranges[0][beam] +
                 (powered ? weightedSum[beam] : unweightedSum[beam]) / (powered ? totalPower[beam] : rayCount);
  }
  for (std::uint32_t ray = 0; ray < group.rays; ++ray) {
    for (std::size_t beam = 0; beam < kGroup; ++beam) {
      const double off = group.ranges[ray][beam] - mean[beam];
      squareSum[beam] += (totalPower[beam] > 0 ? double{group.powers[ray][beam]} : 1.0) * off * off;
    }
  }
  for (std::size_t beam = 0; beam < kGroup; ++beam) {
    group.power[beam] = static_cast<float>(totalPower[beam]);
    group.range[beam] = static_cast<float>(mean[beam]);
    group.spread[beam] =
        static_cast<float>(std::sqrt(squareSum[beam] / (totalPower[beam] > 0 ? totalPower[beam] : rayCount)));
  }
}

struct ClassPower {
  std::uint16_t label = 0;  // class id
  double power = 0;
};

class EchoFinder {
 public:
  EchoFinder(const Hits& hits, std::span<const float> power, double pulseLength)
      : hits_(hits), power_(power), pulse_(pulseLength) {}

  std::vector<Echo> find() {
    echoes_.reserve(hits_.size());
    // The direct rays are sorted by beam. The few rays that continue behind glass or off mirrors come last.
    const std::vector<std::uint32_t>& beamOf = hits_.beamOfRay;
    const auto directRays = static_cast<std::uint32_t>(std::ranges::is_sorted_until(beamOf) - beamOf.begin());
    std::vector<std::uint32_t> continued(beamOf.size() - directRays);  // indices of these rays, sorted by beam
    std::iota(continued.begin(), continued.end(), directRays);
    std::ranges::stable_sort(continued, {}, [&](std::uint32_t ray) { return beamOf[ray]; });
    std::uint32_t ray = 0;
    for (auto next = continued.begin(); ray < directRays || next != continued.end();) {
      const bool isDirect = next == continued.end() || (ray < directRays && beamOf[ray] <= beamOf[*next]);
      const std::uint32_t beam = beamOf[isDirect ? ray : *next];
      const std::uint32_t firstRay = ray;
      const auto firstContinued = next;
      while (ray < directRays && beamOf[ray] == beam) ++ray;
      while (next != continued.end() && beamOf[*next] == beam) ++next;
      if (firstContinued == next && addToGroup(beam, firstRay, ray)) continue;
      addBeam(beam, firstRay, ray, {firstContinued, next});
    }
    finishGroup();
    return std::move(echoes_);
  }

 private:
  // Adds a beam, with the rays first to end - 1, to the group of beams whose echoes are computed together. Adds nothing
  // and returns false if a ray misses, if the ranges differ by more than a pulse, if there are fewer than 2 or more
  // than kMostGroupRays rays, or if the group's beams have another number of rays.
  bool addToGroup(std::uint32_t beam, std::uint32_t first, std::uint32_t end) {
    const std::uint32_t rays = end - first;
    if (rays < 2 || rays > kMostGroupRays || pulse_ == 0 || (group_.rays != 0 && rays != group_.rays)) return false;
    float nearest = kMiss, farthest = 0;
    for (std::uint32_t ray = first; ray < end; ++ray) {
      nearest = std::min(nearest, hits_.range[ray]);
      farthest = std::max(farthest, hits_.range[ray]);
    }
    if (!(farthest < kMiss) || farthest - nearest > pulse_) return false;
    group_.rays = rays;
    group_.echo[group_.count] = echoes_.size();
    group_.first[group_.count] = first;
    for (std::uint32_t ray = 0; ray < rays; ++ray) {
      group_.ranges[ray][group_.count] = hits_.range[first + ray];
      group_.powers[ray][group_.count] = powerOf(first + ray);
    }
    echoes_.push_back({.beam = beam});
    if (++group_.count == kGroup) finishGroup();
    return true;
  }

  // Sets the echoes of the group's beams, which addToGroup() has added to echoes_, and empties the group.
  void finishGroup() {
    if (group_.count == 0) return;
    computeEchoes(group_);
    for (std::size_t i = 0; i < group_.count; ++i) {
      Echo& echo = echoes_[group_.echo[i]];
      const std::uint32_t first = group_.first[i];
      echo.hit = first + group_.strongest[i];
      echo.range = group_.range[i];
      echo.power = group_.power[i];
      echo.spread = group_.spread[i];
      if (hitSeveralClasses(first, first + group_.rays)) {
        rays_.clear();
        for (std::uint32_t ray = first; ray < first + group_.rays; ++ray) {
          rays_.push_back({hits_.range[ray], ray, powerOf(ray)});
        }
        setClassesAndHit(rays_, echo);
      }
      setCause(echo);
    }
    group_.count = 0;
  }

  // Returns true if the rays first to end - 1 hit several classes; false if the classes are not in the hits.
  bool hitSeveralClasses(std::uint32_t first, std::uint32_t end) const {
    if (!hits_.channels.has(Channel::Semantic)) return false;
    std::uint32_t differences = 0;  // bits in which a class differs from the first ray's
    for (std::uint32_t ray = first; ray < end; ++ray) differences |= hits_.semantic[ray] ^ hits_.semantic[first];
    return differences != 0;
  }

  void setCause(Echo& echo) const {
    if (!hits_.pathOfRay.empty() && hits_.pathOfRay[echo.hit] != RayPath::Direct) {
      echo.cause = causeOf(hits_.pathOfRay[echo.hit]);
    }
  }

  float powerOf(std::uint32_t ray) const {
    if (!power_.empty()) return power_[ray];
    return hits_.weightOfRay.empty() ? 1 : hits_.weightOfRay[ray];
  }

  // Adds the echoes of a beam's rays: first to end - 1, and `continued`, the rays behind glass or off mirrors.
  void addBeam(std::uint32_t beam, std::uint32_t first, std::uint32_t end, std::span<const std::uint32_t> continued) {
    rays_.clear();
    const auto addRay = [&](std::uint32_t ray) {
      if (hits_.hit(ray)) rays_.push_back({hits_.range[ray], ray, powerOf(ray)});
    };
    for (std::uint32_t ray = first; ray < end; ++ray) addRay(ray);
    for (const std::uint32_t ray : continued) addRay(ray);
    if (rays_.empty()) return;
    const auto [nearest, farthest] = std::ranges::minmax(rays_, {}, &HitRay::range);
    if (rays_.size() == 1 || (pulse_ > 0 && farthest.range - nearest.range <= pulse_)) {
      addEcho(beam, rays_);  // all rays form one echo: the case of most beams
    } else {
      separateEchoes(beam);
    }
  }

  // Adds the echoes of a beam whose rays are in rays_: sorts the rays by range and begins a new echo at each gap longer
  // than a pulse. Without a pulse length each ray is an echo. Keeps the kMostReturns strongest echoes.
  void separateEchoes(std::uint32_t beam) {
    std::ranges::sort(rays_, {}, [](const HitRay& ray) { return std::pair(ray.range, ray.ray); });
    const std::size_t firstEcho = echoes_.size();
    std::size_t first = 0;  // index of the echo's first ray
    for (std::size_t end = 1; end <= rays_.size(); ++end) {
      if (end < rays_.size() && pulse_ > 0 && rays_[end].range - rays_[end - 1].range <= pulse_) continue;
      addEcho(beam, {rays_.data() + first, end - first});
      first = end;
    }
    while (echoes_.size() - firstEcho > kMostReturns) {
      const auto echoesOfBeam =
          std::ranges::subrange(echoes_.begin() + static_cast<std::ptrdiff_t>(firstEcho), echoes_.end());
      echoes_.erase(std::ranges::min_element(echoesOfBeam, {}, &Echo::power));
    }
  }

  void addEcho(std::uint32_t beam, std::span<const HitRay> rays) {
    echoes_.push_back(echoOf(beam, rays));
    setCause(echoes_.back());
  }

  // Returns the echo of some rays of a beam. Rays that are not within one pulse length must be sorted by range.
  Echo echoOf(std::uint32_t beam, std::span<const HitRay> rays) {
    Echo echo{.beam = beam,
              .hit = rays.front().ray,
              .range = rays.front().range,
              .power = static_cast<float>(rays.front().power)};
    if (rays.size() == 1) return echo;
    const auto [total, mean] = powerAndMean(rays);
    echo.power = static_cast<float>(total);
    double squareSum = 0;
    for (const HitRay& ray : rays) {
      squareSum += (total > 0 ? ray.power : 1.0) * (ray.range - mean) * (ray.range - mean);
    }
    echo.spread = static_cast<float>(std::sqrt(squareSum / (total > 0 ? total : static_cast<double>(rays.size()))));
    const std::span<const HitRay> interval = strongestInterval(rays);
    echo.range = static_cast<float>(interval.size() == rays.size() ? mean : powerAndMean(interval).mean);
    setClassesAndHit(rays, echo);
    return echo;
  }

  struct PowerAndMean {
    double power;
    double mean;  // m, mean of the ranges, weighted by power
  };

  // Returns the sum of the rays' powers, and the mean of their ranges weighted by power (equally if no ray has power).
  static PowerAndMean powerAndMean(std::span<const HitRay> rays) {
    const double firstRange = rays.front().range;
    double total = 0, weightedSum = 0, unweightedSum = 0;
    for (const HitRay& ray : rays) {
      total += ray.power;
      weightedSum += ray.power * (ray.range - firstRange);
      unweightedSum += ray.range - firstRange;
    }
    return {total, firstRange + (total > 0 ? weightedSum / total : unweightedSum / static_cast<double>(rays.size()))};
  }

  // Returns the rays in that interval of one pulse length which contains the most power. `rays`: sorted by range.
  std::span<const HitRay> strongestInterval(std::span<const HitRay> rays) const {
    if (rays.back().range - rays.front().range <= pulse_) return rays;
    std::size_t bestFirst = 0, bestEnd = 1;
    double largestPower = -1, power = 0;
    std::size_t end = 0;
    for (std::size_t first = 0; first < rays.size(); ++first) {
      while (end < rays.size() && rays[end].range - rays[first].range <= pulse_) power += rays[end++].power;
      if (power > largestPower) {
        largestPower = power;
        bestFirst = first;
        bestEnd = end;
      }
      power -= rays[first].power;
    }
    return rays.subspan(bestFirst, bestEnd - bestFirst);
  }

  // Sets the echo's hit (the strongest ray of the class with the most power), the share of this class, and the second
  // class. Of equally strong classes the lowest id comes first; of equally strong rays, the lowest index.
  void setClassesAndHit(std::span<const HitRay> rays, Echo& echo) {
    const bool haveClasses = hits_.channels.has(Channel::Semantic);
    const auto classOf = [&](const HitRay& ray) { return haveClasses ? hits_.semantic[ray.ray] : std::uint16_t{0}; };
    std::uint16_t label = classOf(rays.front());
    if (std::ranges::any_of(rays, [&](const HitRay& ray) { return classOf(ray) != label; })) {
      classPowers_.clear();
      double total = 0;
      for (const HitRay& ray : rays) {
        auto sum = std::ranges::find(classPowers_, classOf(ray), &ClassPower::label);
        if (sum == classPowers_.end()) sum = classPowers_.insert(sum, ClassPower{.label = classOf(ray)});
        sum->power += ray.power;
        total += ray.power;
      }
      std::ranges::sort(classPowers_, {}, [](const ClassPower& sum) { return std::pair(-sum.power, sum.label); });
      label = classPowers_[0].label;
      if (classPowers_[1].power > 0) {
        echo.label2 = classPowers_[1].label;
        echo.share = std::min(static_cast<float>(classPowers_[0].power / total), kBelowOne);
      }
    }
    const HitRay* strongest = nullptr;
    for (const HitRay& ray : rays) {
      if (classOf(ray) != label) continue;
      const bool isStronger = strongest == nullptr || ray.power > strongest->power ||
                              (ray.power == strongest->power && ray.ray < strongest->ray);
      if (isStronger) strongest = &ray;
    }
    echo.hit = strongest->ray;
  }

  const Hits& hits_;
  std::span<const float> power_;         // by ray; empty: the rays' weights are used
  double pulse_;                         // m, length of a pulse
  std::vector<HitRay> rays_;             // buffer: rays of the current beam
  std::vector<ClassPower> classPowers_;  // buffer; a list is fast enough, because a beam hits few classes
  BeamGroup group_{};
  std::vector<Echo> echoes_;
};

}  // namespace

Reason causeOf(RayPath path) {
  return path == RayPath::ThroughGlass ? Reason::ThroughGlass
         : path == RayPath::Mirrored   ? Reason::Mirrored
         : path == RayPath::EgoVehicle ? Reason::EgoVehicle
                                       : Reason::Surface;
}

std::vector<Echo> findEchoes(const Hits& hits, std::span<const float> power, double pulseLength) {
  return EchoFinder(hits, power, pulseLength).find();
}

}  // namespace scanmill
