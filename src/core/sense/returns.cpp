#include "sense/returns.h"

#include <numeric>

#include "base/error.h"

namespace scanmill {

void Returns::clear() {
  for (auto* column : {&range, &gain, &power, &intensity, &spread, &share, &snr}) column->clear();
  displacement.clear();
  label.clear();
  label2.clear();
  instance.clear();
  beam_.clear();
  hit_.clear();
  number_.clear();
  cause_.clear();
  rowsOfBeam_.clear();
  powerOfEchoes = false;
  air.clear();
  recordsReasons_ = false;
  lost_.clear();
  present_.clear();
}

void Returns::recordReasons() {
  recordsReasons_ = true;
  recordLost(Reason::None);
}

// For each row that was lost since the last call, sets the reason to reasonOf(row).
template <class ReasonOf>
void Returns::recordRemoved(const ReasonOf& reasonOf) {
  if (!recordsReasons_) return;
  lost_.resize(size(), Reason::None);
  present_.resize(size(), true);
  for (std::size_t row = 0; row < size(); ++row) {
    if (returned(row) || !present_[row]) continue;
    present_[row] = false;
    lost_[row] = reasonOf(row);
  }
}

void Returns::recordLost(Reason reason) {
  recordRemoved([&](std::size_t) { return reason; });
}

void Returns::recordFaint(std::span<const float> measured, float least) {
  recordRemoved([&](std::size_t row) {
    const bool detectedInClearAir = row < air.size() && measured[row] >= least * air[row];
    return detectedInClearAir ? Reason::LostInAir : Reason::TooFaint;
  });
}

void Returns::start(const Hits& hits) {
  if (!hits.beamOfRay.empty()) return start(findEchoes(hits, {}, 0), false);
  clear();
  onePerBeam_ = true;
  range = hits.range;
  for (const RayPath path : hits.pathOfRay) cause_.push_back(causeOf(path));
}

void Returns::start(std::span<const Echo> echoes, bool powered) {
  clear();
  onePerBeam_ = false;
  powerOfEchoes = powered;
  number_.reserve(echoes.size());
  cause_.reserve(echoes.size());
  for (auto* column : {&beam_, &hit_}) column->reserve(echoes.size());
  for (auto* column : {&range, &spread, &share}) column->reserve(echoes.size());
  label2.reserve(echoes.size());
  for (const Echo& echo : echoes) {
    const bool sameBeam = !beam_.empty() && beam_.back() == echo.beam;
    number_.push_back(static_cast<std::uint8_t>(sameBeam ? number_.back() + 1 : 0));
    beam_.push_back(echo.beam);
    hit_.push_back(echo.hit);
    range.push_back(echo.range);
    spread.push_back(echo.spread);
    share.push_back(echo.share);
    label2.push_back(echo.label2);
    cause_.push_back(echo.cause);
    if (powered) power.push_back(echo.power);
  }
}

// Prepares the table for rows without a hit: fills the columns that may be empty as long as each row has a hit (beams,
// hits, numbers, causes, classes and instances), and counts the rows of each beam.
void Returns::startIndices(const Hits& hits) {
  if (onePerBeam_) {
    onePerBeam_ = false;
    beam_.resize(size());
    std::iota(beam_.begin(), beam_.end(), 0u);
    hit_ = beam_;
    number_.assign(size(), 0);
  }
  cause_.resize(size(), Reason::Surface);
  const auto copyFromHits = [&](const auto& values, auto& column) {
    if (!column.empty() || values.empty()) return;
    column.reserve(size() + 1);
    for (const std::uint32_t hit : hit_) column.push_back(values[hit]);
  };
  copyFromHits(hits.semantic, label);
  copyFromHits(hits.instance, instance);
  rowsOfBeam_.assign(hits.size(), 0);
  for (const std::uint32_t beam : beam_) ++rowsOfBeam_[beam];
}

void Returns::add(const AddedReturn& added, const Hits& hits) {
  if (rowsOfBeam_.empty()) startIndices(hits);
  std::uint8_t& number = rowsOfBeam_[added.beam];
  if (number == kMostReturns) throw Error("beam {} has more than {} returns", added.beam, kMostReturns);
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
  append(intensity, 0.0f);
  append(displacement, Vec3f{});
  append(spread, 0.0f);
  append(share, 1.0f);
  append(label2, std::uint16_t{0});
  append(snr, added.snr);
  append(label, added.label);
  append(instance, std::uint32_t{0});
  // In a table without rows all columns are empty, whether effects have set them or not. The first row therefore sets
  // the columns below.
  if (size() != 1) return;
  intensity = {0.0f};
  power = {added.power};
  if (added.snr > 0) snr = {added.snr};
}

}  // namespace scanmill
