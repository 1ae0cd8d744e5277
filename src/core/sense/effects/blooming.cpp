// blooming: retroreflectors cause returns in beams that point beside them.
//
//   blooming: {share: 0.001, angle_deg: 0.5}
//
// A small part of the light is scattered in the optics, and a retroreflector, hundreds of times as bright as a white
// target, returns enough of this light to be detected. A beam at the angle t to a beam that hits a retroreflector gets
// one more echo, at the same range and with the strength
//
//   retroreflectance cos(incidence) share exp(-2 t^2 / angle^2)
//
// in units of a white target at this range, with cause 7 (StrayLight). If several retroreflectors are near, a beam gets
// only the strongest of these echoes. An echo within a pulse length of another return of the beam is not added, since
// the two would merge.

#include <algorithm>
#include <cmath>
#include <vector>

#include "sense/effects/elementary.h"
#include "sense/effects/makers.h"
#include "sensors/footprint.h"

namespace scanmill {
namespace {

struct BloomingOptions {
  double share;         // echo in the middle of the halo, relative to the retroreflector's echo
  double angle;         // rad, angle at which the halo has fallen to 1/e^2
  float above;          // least retroreflectance that blooms
  std::uint16_t label;  // class of the returns
};

// An echo of a retroreflector in a beam that points beside it.
struct Stray {
  float echo = 0;   // power relative to the echo of a white target at the same range
  float range = 0;  // m
};

class Blooming : public Effect {
 public:
  explicit Blooming(const BloomingOptions& options) : o_(options) {}

  Channels reads() const override { return Channel::Range | Channel::Material | Channels(Channel::Incidence); }
  bool setsGain() const override { return true; }
  std::uint32_t mostReturns(std::uint32_t before) const override { return std::min(before + 1, kMostReturns); }

  void apply(const Hits& hits, const Shot& shot, std::span<const Material> materials, Returns& returns) const override {
    std::vector<Source> sources;
    for (std::uint32_t row = 0; row < returns.size(); ++row) {
      const std::uint32_t hit = returns.hit(row);
      if (!returns.returned(row) || hit == kNoHit) continue;
      const float retro = retroreflectanceOf(hits, materials, hit);
      if (retro < o_.above) continue;
      const float gain = returns.gain.empty() ? 1 : returns.gain[row];
      sources.push_back({returns.beam(row), returns.range[row], retro * hits.incidence[hit] * gain});
    }
    if (!sources.empty()) addStrays(hits, *shot.beams, straysOf(*shot.beams, sources), returns);
  }

 private:
  // A return of a beam that hits a retroreflector.
  struct Source {
    std::uint32_t beam;
    float range;  // m
    float echo;   // power relative to the echo of a white target at the same range
  };

  static float retroreflectanceOf(const Hits& hits, std::span<const Material> materials, std::uint32_t hit) {
    if (!hits.retroreflectance.empty()) return hits.retroreflectance[hit];
    return hits.material[hit] < materials.size() ? materials[hits.material[hit]].retroreflectance : 0.0f;
  }

  // Returns the strongest stray echo of each beam; an echo of 0 means that the beam gets none. Beyond 2 * angle from a
  // source the halo (0.03 % of its peak) is ignored.
  std::vector<Stray> straysOf(const BeamTable& beams, const std::vector<Source>& sources) const {
    std::vector<Stray> strays(beams.size());
    const double haloAngle = 2 * o_.angle;
    const double leastCosine = std::cos(haloAngle);
    // Number of columns to search on each side, enough for neighbours in any ring; addHalo() compares the directions.
    const double columnStep = beams.fullTurn() ? 2 * kPi / beams.columns : beams.field / beams.columns;
    const auto reach = static_cast<std::int64_t>(std::ceil((haloAngle + widestOffset(beams)) / columnStep)) + 1;
    for (const Source& source : sources) {
      const std::int64_t sourceColumn = source.beam % beams.columns;
      const std::uint32_t sourceRing = source.beam / beams.columns;
      for (std::uint32_t ring = 0; ring < beams.rings; ++ring) {
        if (!beams.elevation.empty() && std::abs(beams.elevation[ring] - beams.elevation[sourceRing]) > haloAngle) {
          continue;
        }
        for (std::int64_t column = sourceColumn - reach; column <= sourceColumn + reach; ++column) {
          const std::int64_t wrapped = beams.fullTurn() ? (column + beams.columns) % beams.columns : column;
          if (wrapped < 0 || wrapped >= beams.columns) continue;
          const std::uint32_t beam = ring * beams.columns + static_cast<std::uint32_t>(wrapped);
          if (beam != source.beam) addHalo(beams, source, beam, leastCosine, strays[beam]);
        }
      }
    }
    return strays;
  }

  // Returns the largest difference of two rings' azimuth offsets (rad).
  static double widestOffset(const BeamTable& beams) {
    if (beams.azimuthOffset.empty()) return 0;
    const auto [least, most] = std::ranges::minmax(beams.azimuthOffset);
    return most - least;
  }

  // Sets `stray` to the echo of the source's halo in a beam, if it is stronger than `stray`. Of two equally strong
  // echoes the nearer one counts.
  void addHalo(const BeamTable& beams, const Source& source, std::uint32_t beam, double leastCosine,
               Stray& stray) const {
    const double cosine = dot(beams.direction[source.beam], beams.direction[beam]);
    if (cosine < leastCosine) return;
    const double angleSquared = 2 * (1 - std::min(1.0, cosine));  // rad^2, for small angles
    const double haloEcho = double{source.echo} * o_.share * exponential(-2 * angleSquared / (o_.angle * o_.angle));
    const auto echo = static_cast<float>(haloEcho);
    if (echo > stray.echo || (echo == stray.echo && source.range < stray.range)) stray = {echo, source.range};
  }

  // Adds a return for each stray echo (`strays`: by beam) that is not within a pulse length of its beam's other
  // returns.
  void addStrays(const Hits& hits, const BeamTable& beams, const std::vector<Stray>& strays, Returns& returns) const {
    const auto length = static_cast<float>(pulseLength(beams.pulse));
    std::vector<bool> joinsAReturn(strays.size());
    for (std::uint32_t row = 0; row < returns.size(); ++row) {
      if (!returns.returned(row)) continue;
      const std::uint32_t beam = returns.beam(row);
      joinsAReturn[beam] = joinsAReturn[beam] || std::abs(returns.range[row] - strays[beam].range) <= length;
    }
    for (std::uint32_t beam = 0; beam < strays.size(); ++beam) {
      if (strays[beam].echo <= 0 || joinsAReturn[beam] || returns.full(beam)) continue;
      const auto [echo, range] = strays[beam];
      returns.add({.beam = beam, .range = range, .power = echo, .cause = Reason::StrayLight, .label = o_.label}, hits);
    }
  }

  BloomingOptions o_;
};

}  // namespace

std::unique_ptr<Effect> makeBlooming(Fields& options) {
  const BloomingOptions o{.share = options.number("share", {1e-9, 1}, 0.001),
                          .angle = radians(options.number("angle_deg", {0.01, 20}, 0.5)),
                          .above = static_cast<float>(options.number("above", {1e-6, 1e6}, 10)),
                          .label = static_cast<std::uint16_t>(options.integer("label", 0, 65535, 0))};
  options.finish();
  return std::make_unique<Blooming>(o);
}

}  // namespace scanmill
