// footprint: a beam of finite width, sampled by several rays. docs/sensing.md explains mixed pixels and their columns.
//
//   footprint: {rays: 19}      # 7, 19, 37, 61, 91 or 127
//
// The code is in sensors/footprint.h, which makes the rays, and sense/echoes.cpp, which joins them to echoes.

#include "sensors/footprint.h"

#include <algorithm>

#include "sense/effects/makers.h"

namespace scanmill {
namespace {

class FootprintEffect : public Effect {
 public:
  FootprintEffect(std::uint32_t rays, Location where) : rays_(rays), where_(std::move(where)) {}

  std::uint32_t raysPerBeam() const override { return rays_; }
  std::uint32_t mostReturns(std::uint32_t before) const override {
    return std::max(before, std::min(rays_, kMostReturns));
  }

  void check(const BeamTable& beams) const override {
    constexpr std::array<double, 2> kNoWidth{};
    if (beams.divergence == kNoWidth && beams.exitWidth == kNoWidth) {
      throw InputError(where_,
                       "effect footprint: the width of the beams is missing: add `divergence_mrad: 3`, with the data "
                       "sheet's value, to the sensor");
    }
    if (beams.pulse == 0) {
      throw InputError(where_,
                       "effect footprint: the length of the pulses is missing, which decides whether two echoes are "
                       "separate: add `pulse_ns: 5`, with the data sheet's value, to the sensor");
    }
  }

  void apply(const Hits&, const Shot&, std::span<const Material>, Returns&) const override {}

 private:
  std::uint32_t rays_;
  Location where_;
};

}  // namespace

std::unique_ptr<Effect> makeFootprintEffect(Fields& options) {
  options.also({"rays"}).finish();
  const auto rays = static_cast<std::uint32_t>(options.integer("rays", 7, 127));
  options.finish();
  if (std::find(std::begin(kFootprintRays), std::end(kFootprintRays), rays) == std::end(kFootprintRays)) {
    throw InputError(
        options.find("rays")->where,
        "effect footprint: the rays of a beam lie on hexagons, so that `rays` must be 7, 19, 37, 61, 91 or 127");
  }
  return std::make_unique<FootprintEffect>(rays, options.where());
}

}  // namespace scanmill
