#include "sense/returns.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr std::uint8_t kMostReturns = 16;  // of a beam: as many addresses of random numbers has it

}  // namespace

void Returns::start(const Hits& hits) {
  for (auto* column : {&gain, &power, &intensity}) column->clear();
  displacement.clear();
  label.clear();
  instance.clear();
  beam_.clear();
  hit_.clear();
  number_.clear();
  cause_.clear();
  rowsOfBeam_.clear();
  onePerBeam_ = hits.beamOfRay.empty();
  if (onePerBeam_) {
    range = hits.range;
  } else {
    startOfSeveral(hits);
  }
}

void Returns::startOfSeveral(const Hits& hits) {
  for (std::uint32_t ray = 0; ray < hits.rays(); ++ray) {
    if (hits.hit(ray)) hit_.push_back(ray);
  }
  std::sort(hit_.begin(), hit_.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (hits.beamOfRay[a] != hits.beamOfRay[b]) return hits.beamOfRay[a] < hits.beamOfRay[b];
    return hits.range[a] != hits.range[b] ? hits.range[a] < hits.range[b] : a < b;
  });
  range.clear();
  for (const std::uint32_t ray : hit_) {
    const std::uint32_t beam = hits.beamOfRay[ray];
    const bool further = !beam_.empty() && beam_.back() == beam;
    if (further && number_.back() + 1 == kMostReturns) {
      throw Error(fmt::format("beam {} has more than {} returns", beam, kMostReturns));
    }
    number_.push_back(static_cast<std::uint8_t>(further ? number_.back() + 1 : 0));
    beam_.push_back(beam);
    range.push_back(hits.range[ray]);
  }
  cause_.assign(range.size(), Cause::Surface);
}

void Returns::makeIndices(const Hits& hits) {
  if (onePerBeam_) {
    onePerBeam_ = false;
    beam_.resize(size());
    std::iota(beam_.begin(), beam_.end(), 0u);
    hit_ = beam_;
    number_.assign(size(), 0);
    cause_.assign(size(), Cause::Surface);
  }
  const auto ofHits = [&](const auto& values, auto& to) {
    if (!to.empty() || values.empty()) return;
    to.reserve(size() + 1);
    for (const std::uint32_t hit : hit_) to.push_back(values[hit]);
  };
  ofHits(hits.semantic, label);
  ofHits(hits.instance, instance);
  rowsOfBeam_.assign(hits.size(), 0);
  for (const std::uint32_t beam : beam_) ++rowsOfBeam_[beam];
}

void Returns::add(const AddedReturn& added, const Hits& hits) {
  if (rowsOfBeam_.empty()) makeIndices(hits);
  std::uint8_t& number = rowsOfBeam_[added.beam];
  if (number == kMostReturns) throw Error(fmt::format("beam {} has more than {} returns", added.beam, kMostReturns));
  beam_.push_back(added.beam);
  hit_.push_back(kNoHit);
  number_.push_back(number++);
  cause_.push_back(added.cause);
  range.push_back(added.range);
  const auto append = [](auto& column, auto value) {
    if (!column.empty()) column.push_back(value);
  };
  if (power.empty() && added.power > 0) power.resize(size() - 1);
  append(gain, 1.0f);
  append(power, added.power);
  append(intensity, added.intensity);
  append(displacement, Vec3f{});
  append(label, added.label);
  append(instance, added.instance);
}

}  // namespace scanmill
