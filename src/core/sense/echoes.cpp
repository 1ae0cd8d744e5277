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
struct Part {
  float range;
  std::uint32_t ray;
  double power;
};

constexpr std::size_t kTogether = 64;    // number of beams whose echoes are computed together
constexpr std::uint32_t kMostRays = 19;  // largest number of rays of such a beam

// Beams of equally many rays that form one echo each.
struct Simple {
  template <class T>
  using PerBeam = std::array<T, kTogether>;

  std::uint32_t rays = 0;
  std::size_t count = 0;
  PerBeam<std::size_t> echo;         // index in the list of echoes
  PerBeam<std::uint32_t> first;      // the beam's first ray; the others follow
  PerBeam<std::uint32_t> strongest;  // index of the ray with the most power, the first among equals
  PerBeam<float> power;
  PerBeam<float> range;
  PerBeam<float> spread;
  std::array<PerBeam<float>, kMostRays> ranges;  // by ray
  std::array<PerBeam<float>, kMostRays> powers;
};

// Computes power, range, spread and the strongest ray of each beam. The operations are those of EchoFinder::echoOf().
SCANMILL_BEST_INSTRUCTIONS void computeEchoes(Simple& s) {
  Simple::PerBeam<double> total{};
  Simple::PerBeam<double> sum{};
  Simple::PerBeam<double> plain{};
  Simple::PerBeam<double> square{};
  Simple::PerBeam<float> most;
  most.fill(-1);
  s.strongest.fill(0);
  for (std::uint32_t k = 0; k < s.rays; ++k) {
    for (std::size_t i = 0; i < kTogether; ++i) {
      const double power = s.powers[k][i];
      const double behind = s.ranges[k][i] - double{s.ranges[0][i]};
      total[i] += power;
      sum[i] += power * behind;
      plain[i] += behind;
      s.strongest[i] = s.powers[k][i] > most[i] ? k : s.strongest[i];
      most[i] = s.powers[k][i] > most[i] ? s.powers[k][i] : most[i];
    }
  }
  Simple::PerBeam<double> mean;
  const double rays = s.rays;
  for (std::size_t i = 0; i < kTogether; ++i) {
    const bool powered = total[i] > 0;
    mean[i] = s.ranges[0][i] + (powered ? sum[i] : plain[i]) / (powered ? total[i] : rays);
  }
  for (std::uint32_t k = 0; k < s.rays; ++k) {
    for (std::size_t i = 0; i < kTogether; ++i) {
      const double off = s.ranges[k][i] - mean[i];
      square[i] += (total[i] > 0 ? double{s.powers[k][i]} : 1.0) * off * off;
    }
  }
  for (std::size_t i = 0; i < kTogether; ++i) {
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
    std::vector<std::uint32_t> others(beamOf.size() - sorted);
    std::iota(others.begin(), others.end(), sorted);
    std::stable_sort(others.begin(), others.end(), [&](auto a, auto b) { return beamOf[a] < beamOf[b]; });
    std::uint32_t ray = 0;
    for (auto other = others.begin(); ray < sorted || other != others.end();) {
      const std::uint32_t beam =
          other == others.end() || (ray < sorted && beamOf[ray] <= beamOf[*other]) ? beamOf[ray] : beamOf[*other];
      if (ray < sorted && beamOf[ray] == beam && (other == others.end() || beamOf[*other] != beam)) {
        std::uint32_t end = ray + 1;
        while (end < sorted && beamOf[end] == beam) ++end;
        if (takeSimple(beam, ray, end)) {
          ray = end;
          continue;
        }
      }
      parts_.clear();
      float nearest = kMiss;
      float farthest = 0;
      const auto take = [&](std::uint32_t taken) {
        if (!hits_.hit(taken)) return;
        const float range = hits_.range[taken];
        parts_.push_back({range, taken, powerOf(taken)});
        nearest = std::min(nearest, range);
        farthest = std::max(farthest, range);
      };
      for (; ray < sorted && beamOf[ray] == beam; ++ray) take(ray);
      for (; other != others.end() && beamOf[*other] == beam; ++other) take(*other);
      if (parts_.size() == 1 || (!parts_.empty() && pulse_ > 0 && farthest - nearest <= pulse_)) {
        addEcho(beam, parts_);  // all rays form one echo: the case of most beams
      } else if (!parts_.empty()) {
        addBeam(beam);
      }
    }
    finishSimple();
    return std::move(echoes_);
  }

 private:
  // Takes the rays first to end - 1 of a beam if all hit something and form one echo. Returns false if they do not, or
  // if the beam has not as many rays as the first such beam.
  bool takeSimple(std::uint32_t beam, std::uint32_t first, std::uint32_t end) {
    const std::uint32_t rays = end - first;
    if (rays < 2 || rays > kMostRays || pulse_ == 0 || (simple_.rays != 0 && rays != simple_.rays)) return false;
    float nearest = kMiss;
    float farthest = 0;
    for (std::uint32_t ray = first; ray < end; ++ray) {
      nearest = std::min(nearest, hits_.range[ray]);
      farthest = std::max(farthest, hits_.range[ray]);
    }
    if (!(farthest < kMiss) || farthest - nearest > pulse_) return false;
    simple_.rays = rays;
    simple_.echo[simple_.count] = echoes_.size();
    simple_.first[simple_.count] = first;
    for (std::uint32_t k = 0; k < rays; ++k) {
      simple_.ranges[k][simple_.count] = hits_.range[first + k];
      simple_.powers[k][simple_.count] = powerOf(first + k);
    }
    echoes_.push_back({.beam = beam});
    if (++simple_.count == kTogether) finishSimple();
    return true;
  }

  void finishSimple() {
    if (simple_.count == 0) return;
    computeEchoes(simple_);
    for (std::size_t i = 0; i < simple_.count; ++i) {
      Echo& echo = echoes_[simple_.echo[i]];
      const std::uint32_t first = simple_.first[i];
      echo.hit = first + simple_.strongest[i];
      echo.range = simple_.range[i];
      echo.power = simple_.power[i];
      echo.spread = simple_.spread[i];
      if (mixed(first, first + simple_.rays)) {
        parts_.clear();
        double total = 0;
        for (std::uint32_t ray = first; ray < first + simple_.rays; ++ray) {
          parts_.push_back({hits_.range[ray], ray, powerOf(ray)});
          total += parts_.back().power;
        }
        echo.hit = first;
        label(parts_, total, echo);
      }
      setCause(echo);
    }
    simple_.count = 0;
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

  void addBeam(std::uint32_t beam) {
    std::sort(parts_.begin(), parts_.end(),
              [](const Part& a, const Part& b) { return a.range != b.range ? a.range < b.range : a.ray < b.ray; });
    const std::size_t before = echoes_.size();
    std::size_t first = 0;
    for (std::size_t i = 1; i <= parts_.size(); ++i) {
      const bool joined = i < parts_.size() && pulse_ > 0 && parts_[i].range - parts_[i - 1].range <= pulse_;
      if (joined) continue;
      addEcho(beam, {parts_.data() + first, i - first});
      first = i;
    }
    keepStrongest(before);
  }

  void addEcho(std::uint32_t beam, std::span<const Part> parts) {
    echoes_.push_back(echoOf(beam, parts));
    setCause(echoes_.back());
  }

  void keepStrongest(std::size_t first) {
    while (echoes_.size() - first > kMostReturns) {
      echoes_.erase(std::min_element(echoes_.begin() + static_cast<std::ptrdiff_t>(first), echoes_.end(),
                                     [](const Echo& a, const Echo& b) { return a.power < b.power; }));
    }
  }

  // Returns the echo of some rays of a beam. The rays must be sorted by range, unless all of them are within one pulse
  // length.
  Echo echoOf(std::uint32_t beam, std::span<const Part> parts) {
    Echo echo{beam, parts.front().ray, parts.front().range, static_cast<float>(parts.front().power)};
    if (parts.size() == 1) return echo;
    const auto [total, mean] = powerAndMean(parts);
    echo.power = static_cast<float>(total);
    double square = 0;
    for (const Part& p : parts) square += (total > 0 ? p.power : 1.0) * (p.range - mean) * (p.range - mean);
    echo.spread = static_cast<float>(std::sqrt(square / (total > 0 ? total : static_cast<double>(parts.size()))));
    const std::span<const Part> stretch = strongestStretch(parts);
    echo.range = static_cast<float>(stretch.size() == parts.size() ? mean : powerAndMean(stretch).mean);
    label(parts, total, echo);
    return echo;
  }

  struct PowerAndMean {
    double power;
    double mean;  // m, mean of the ranges, weighted by power
  };

  // Returns the sum of the rays' powers, and the mean of their ranges weighted by power. If no ray has power, all have
  // equal weight.
  static PowerAndMean powerAndMean(std::span<const Part> parts) {
    const double first = parts.front().range;
    double total = 0;
    double sum = 0;
    double plain = 0;
    for (const Part& p : parts) {
      total += p.power;
      sum += p.power * (p.range - first);
      plain += p.range - first;
    }
    return {total, first + (total > 0 ? sum / total : plain / static_cast<double>(parts.size()))};
  }

  std::span<const Part> strongestStretch(std::span<const Part> parts) const {
    if (parts.back().range - parts.front().range <= pulse_) return parts;
    std::size_t bestFirst = 0;
    std::size_t bestEnd = 1;
    double best = -1;
    double power = 0;
    std::size_t end = 0;
    for (std::size_t first = 0; first < parts.size(); ++first) {
      while (end < parts.size() && parts[end].range - parts[first].range <= pulse_) power += parts[end++].power;
      if (power > best) {
        best = power;
        bestFirst = first;
        bestEnd = end;
      }
      power -= parts[first].power;
    }
    return parts.subspan(bestFirst, bestEnd - bestFirst);
  }

  void label(std::span<const Part> parts, double total, Echo& echo) {
    const bool classes = hits_.channels.has(Channel::Semantic);
    const std::uint16_t first = classes ? hits_.semantic[parts.front().ray] : std::uint16_t{0};
    const bool mixed = classes && std::any_of(parts.begin(), parts.end(),
                                              [&](const Part& p) { return hits_.semantic[p.ray] != first; });
    std::uint16_t most = first;
    if (mixed) {
      powers_.clear();
      for (const Part& p : parts) powers_.add(hits_.semantic[p.ray], p.power);
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
    for (const Part& p : parts) {
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
  std::vector<Part> parts_;
  ClassPowers powers_;
  Simple simple_{};
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
