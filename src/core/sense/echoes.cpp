#include "sense/echoes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/instruction_sets.h"

namespace scanmill {

namespace {

constexpr float kBelowOne = 0.99999994f;  // the largest float below 1: upper bound of `share` if an echo has two
                                          // classes

// A ray with a hit; `power` is the ray's contribution to an echo.
struct HitRay {
  float range;
  std::uint32_t ray;
  double power;
};

constexpr std::size_t kGroup = 64;            // number of beams whose echoes are computed together
constexpr std::uint32_t kMostGroupRays = 19;  // largest number of rays of such a beam

// A group of beams that form one echo each, of equally many rays, computed together.
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

// Computes power, range, spread and the strongest ray of each beam. The operations are those of EchoFinder::echoOf().
SCANMILL_BEST_INSTRUCTIONS void computeEchoes(BeamGroup& s) {
  BeamGroup::PerBeam<double> total{}, sum{}, unweighted{}, square{};
  BeamGroup::PerBeam<float> most;
  most.fill(-1);
  s.strongest.fill(0);
  for (std::uint32_t k = 0; k < s.rays; ++k) {
    for (std::size_t i = 0; i < kGroup; ++i) {
      const double power = s.powers[k][i];
      const double behindFirst = s.ranges[k][i] - double{s.ranges[0][i]};
      total[i] += power;
      sum[i] += power * behindFirst;
      unweighted[i] += behindFirst;
      s.strongest[i] = s.powers[k][i] > most[i] ? k : s.strongest[i];
      most[i] = s.powers[k][i] > most[i] ? s.powers[k][i] : most[i];
    }
  }
  BeamGroup::PerBeam<double> mean;
  const double rays = s.rays;
  for (std::size_t i = 0; i < kGroup; ++i) {
    const bool powered = total[i] > 0;
    mean[i] = s.ranges[0][i] + (powered ? sum[i] : unweighted[i]) / (powered ? total[i] : rays);
  }
  for (std::uint32_t k = 0; k < s.rays; ++k) {
    for (std::size_t i = 0; i < kGroup; ++i) {
      const double off = s.ranges[k][i] - mean[i];
      square[i] += (total[i] > 0 ? double{s.powers[k][i]} : 1.0) * off * off;
    }
  }
  for (std::size_t i = 0; i < kGroup; ++i) {
    s.power[i] = static_cast<float>(total[i]);
    s.range[i] = static_cast<float>(mean[i]);
    s.spread[i] = static_cast<float>(std::sqrt(square[i] / (total[i] > 0 ? total[i] : rays)));
  }
}

// Sums of power by class. A list is fast enough, because a beam hits few classes.
class ClassPowers {
 public:
  void clear() { entries_.clear(); }

  void add(std::uint16_t label, double power) {
    for (Entry& e : entries_) {
      if (e.label != label) continue;
      e.power += power;
      return;
    }
    entries_.push_back({label, power});
  }

  struct Entry {
    std::uint16_t label = 0;
    double power = 0;
  };

  // Returns the class with the most power; among classes with equal power, the one with the lowest id. Ignores the
  // class of `other`, unless `other` is null. The power is -1 if no class remains.
  Entry strongest(const Entry* other) const {
    Entry best{0, -1};
    for (const Entry& e : entries_) {
      if (other != nullptr && e.label == other->label) continue;
      if (e.power > best.power || (e.power == best.power && e.label < best.label)) best = e;
    }
    return best;
  }

 private:
  std::vector<Entry> entries_;
};

class EchoFinder {
 public:
  EchoFinder(const Hits& hits, std::span<const float> power, double pulseLength)
      : hits_(hits), power_(power), pulse_(pulseLength) {}

  std::vector<Echo> find() {
    echoes_.reserve(hits_.size());
    // The rays from the sensor are sorted by beam. Behind them are the few that continue behind glass or off mirrors.
    const std::vector<std::uint32_t>& beamOf = hits_.beamOfRay;
    const auto sorted = static_cast<std::uint32_t>(std::is_sorted_until(beamOf.begin(), beamOf.end()) - beamOf.begin());
    std::vector<std::uint32_t> continued(beamOf.size() - sorted);
    std::iota(continued.begin(), continued.end(), sorted);
    std::stable_sort(continued.begin(), continued.end(), [&](auto a, auto b) { return beamOf[a] < beamOf[b]; });
    std::uint32_t ray = 0;
    for (auto next = continued.begin(); ray < sorted || next != continued.end();) {
      const std::uint32_t beam =
          next == continued.end() || (ray < sorted && beamOf[ray] <= beamOf[*next]) ? beamOf[ray] : beamOf[*next];
      const std::uint32_t first = ray;
      const auto firstContinued = next;
      while (ray < sorted && beamOf[ray] == beam) ++ray;
      while (next != continued.end() && beamOf[*next] == beam) ++next;
      if (firstContinued == next && addToGroup(beam, first, ray)) continue;
      addBeam(beam, first, ray, {firstContinued, next});
    }
    finishGroup();
    return std::move(echoes_);
  }

 private:
  // Takes the rays first to end - 1 of a beam if all hit something and form one echo. Returns false if they do not, or
  // if the beam has not as many rays as the first such beam.
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
    for (std::uint32_t k = 0; k < rays; ++k) {
      group_.ranges[k][group_.count] = hits_.range[first + k];
      group_.powers[k][group_.count] = powerOf(first + k);
    }
    echoes_.push_back({.beam = beam});
    if (++group_.count == kGroup) finishGroup();
    return true;
  }

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
      if (mixed(first, first + group_.rays)) {
        rays_.clear();
        double total = 0;
        for (std::uint32_t ray = first; ray < first + group_.rays; ++ray) {
          rays_.push_back({hits_.range[ray], ray, powerOf(ray)});
          total += rays_.back().power;
        }
        echo.hit = first;
        label(rays_, total, echo);
      }
      setCause(echo);
    }
    group_.count = 0;
  }

  // Returns true if neighbouring rays hit several classes.
  bool mixed(std::uint32_t first, std::uint32_t end) const {
    if (!hits_.channels.has(Channel::Semantic)) return false;
    std::uint32_t others = 0;
    for (std::uint32_t ray = first; ray < end; ++ray) others |= hits_.semantic[ray] ^ hits_.semantic[first];
    return others != 0;
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

  // Adds the echoes of a beam, of its rays first to end - 1 and of those that continue behind glass or off mirrors.
  void addBeam(std::uint32_t beam, std::uint32_t first, std::uint32_t end, std::span<const std::uint32_t> continued) {
    rays_.clear();
    const auto addRay = [&](std::uint32_t ray) {
      if (hits_.hit(ray)) rays_.push_back({hits_.range[ray], ray, powerOf(ray)});
    };
    for (std::uint32_t ray = first; ray < end; ++ray) addRay(ray);
    for (const std::uint32_t ray : continued) addRay(ray);
    if (rays_.empty()) return;
    const auto [nearest, farthest] = std::minmax_element(
        rays_.begin(), rays_.end(), [](const HitRay& a, const HitRay& b) { return a.range < b.range; });
    if (rays_.size() == 1 || (pulse_ > 0 && farthest->range - nearest->range <= pulse_)) {
      addEcho(beam, rays_);  // all rays form one echo: the case of most beams
    } else {
      separateEchoes(beam);
    }
  }

  // Splits the beam's sorted ranges at gaps above a pulse length into echoes. Without pulse length, each ray is one.
  void separateEchoes(std::uint32_t beam) {
    std::sort(rays_.begin(), rays_.end(),
              [](const HitRay& a, const HitRay& b) { return a.range != b.range ? a.range < b.range : a.ray < b.ray; });
    const std::size_t before = echoes_.size();
    std::size_t first = 0;
    for (std::size_t i = 1; i <= rays_.size(); ++i) {
      const bool joined = i < rays_.size() && pulse_ > 0 && rays_[i].range - rays_[i - 1].range <= pulse_;
      if (joined) continue;
      addEcho(beam, {rays_.data() + first, i - first});
      first = i;
    }
    while (echoes_.size() - before > kMostReturns) {  // only the strongest are kept
      echoes_.erase(std::min_element(echoes_.begin() + static_cast<std::ptrdiff_t>(before), echoes_.end(),
                                     [](const Echo& a, const Echo& b) { return a.power < b.power; }));
    }
  }

  void addEcho(std::uint32_t beam, std::span<const HitRay> rays) {
    echoes_.push_back(echoOf(beam, rays));
    setCause(echoes_.back());
  }

  // Returns the echo of some rays of a beam. The rays must be sorted by range, unless all of them are within one pulse
  // length.
  Echo echoOf(std::uint32_t beam, std::span<const HitRay> rays) {
    Echo echo{beam, rays.front().ray, rays.front().range, static_cast<float>(rays.front().power)};
    if (rays.size() == 1) return echo;
    const auto [total, mean] = powerAndMean(rays);
    echo.power = static_cast<float>(total);
    double square = 0;
    for (const HitRay& p : rays) square += (total > 0 ? p.power : 1.0) * (p.range - mean) * (p.range - mean);
    echo.spread = static_cast<float>(std::sqrt(square / (total > 0 ? total : static_cast<double>(rays.size()))));
    const std::span<const HitRay> interval = strongestInterval(rays);
    echo.range = static_cast<float>(interval.size() == rays.size() ? mean : powerAndMean(interval).mean);
    label(rays, total, echo);
    return echo;
  }

  struct PowerAndMean {
    double power;
    double mean;  // m, mean of the ranges, weighted by power
  };

  // Returns the sum of the rays' powers, and the mean of their ranges weighted by power. If no ray has power, all have
  // equal weight.
  static PowerAndMean powerAndMean(std::span<const HitRay> rays) {
    const double first = rays.front().range;
    double total = 0, sum = 0, unweighted = 0;
    for (const HitRay& p : rays) {
      total += p.power;
      sum += p.power * (p.range - first);
      unweighted += p.range - first;
    }
    return {total, first + (total > 0 ? sum / total : unweighted / static_cast<double>(rays.size()))};
  }

  // Returns the rays within the interval of one pulse length that has the most power.
  std::span<const HitRay> strongestInterval(std::span<const HitRay> rays) const {
    if (rays.back().range - rays.front().range <= pulse_) return rays;
    std::size_t bestFirst = 0, bestEnd = 1;
    double most = -1, power = 0;
    std::size_t end = 0;
    for (std::size_t first = 0; first < rays.size(); ++first) {
      while (end < rays.size() && rays[end].range - rays[first].range <= pulse_) power += rays[end++].power;
      if (power > most) {
        most = power;
        bestFirst = first;
        bestEnd = end;
      }
      power -= rays[first].power;
    }
    return rays.subspan(bestFirst, bestEnd - bestFirst);
  }

  // Sets the echo's classes, the share of the first, and its hit: the strongest ray of the first class.
  void label(std::span<const HitRay> rays, double total, Echo& echo) {
    const bool classes = hits_.channels.has(Channel::Semantic);
    const std::uint16_t first = classes ? hits_.semantic[rays.front().ray] : std::uint16_t{0};
    const bool mixed = classes && std::any_of(rays.begin(), rays.end(),
                                              [&](const HitRay& p) { return hits_.semantic[p.ray] != first; });
    std::uint16_t most = first;
    if (mixed) {
      powers_.clear();
      for (const HitRay& p : rays) powers_.add(hits_.semantic[p.ray], p.power);
      const ClassPowers::Entry strongest = powers_.strongest(nullptr);
      most = strongest.label;
      const ClassPowers::Entry next = powers_.strongest(&strongest);
      if (next.power > 0) {
        echo.label2 = next.label;
        echo.share = std::min(static_cast<float>(strongest.power / total), kBelowOne);
      }
    } else if (classes) {
      echo.share = 1;
    }
    double strongest = -1;
    for (const HitRay& p : rays) {
      if (mixed && hits_.semantic[p.ray] != most) continue;
      if (p.power > strongest || (p.power == strongest && p.ray < echo.hit)) {
        strongest = p.power;
        echo.hit = p.ray;
      }
    }
  }

  const Hits& hits_;
  std::span<const float> power_;
  double pulse_;
  std::vector<HitRay> rays_;
  ClassPowers powers_;
  BeamGroup group_{};
  std::vector<Echo> echoes_;
};

}  // namespace

Reason causeOf(RayPath path) {
  switch (path) {
    case RayPath::ThroughGlass:
      return Reason::ThroughGlass;
    case RayPath::Mirrored:
      return Reason::Mirrored;
    case RayPath::EgoVehicle:
      return Reason::EgoVehicle;
    case RayPath::Direct:
      break;
  }
  return Reason::Surface;
}

std::vector<Echo> findEchoes(const Hits& hits, std::span<const float> power, double pulseLength) {
  return EchoFinder(hits, power, pulseLength).find();
}

}  // namespace scanmill
