#include "sense/sense.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "sense/echoes.h"
#include "sensors/footprint.h"

namespace scanmill {

namespace {

void checkHits(const Hits& hits, const Shot& shot, Channels needed) {
  const BeamTable& beams = *shot.beams;
  const std::size_t rays = hits.beamOfRay.empty() ? hits.size() : hits.beamOfRay.size();
  if (hits.rings != beams.rings || hits.columns != beams.columns || hits.rays() != rays) {
    throw Error(fmt::format("hits of {} x {} beams do not belong to a sensor of {} x {}", hits.rings, hits.columns,
                            beams.rings, beams.columns));
  }
  const Channels missing = needed.without(hits.channels);
  if (missing != Channels()) {
    throw Error(fmt::format("hits lack the channel {} that the effects and the columns asked for need",
                            channelNames(missing).front()));
  }
}

constexpr float kSmooth = 0.1f;  // largest roughness of a surface that reflects like a mirror
constexpr float kMetal = 0.5f;

Reason ofFaint(const Hits& hits, std::span<const Material> materials, std::uint32_t hit) {
  if (hit == kNoHit || hits.material.empty() || hits.material[hit] >= materials.size()) return Reason::TooFaint;
  const Material& material = materials[hits.material[hit]];
  if (material.transmission > 0 && hits.glassIsClear) return Reason::LostInGlass;
  return material.roughness <= kSmooth || material.metallic >= kMetal ? Reason::MirroredAway : Reason::TooFaint;
}

// Sets the reason of beams whose rays hit nothing reportable.
void fillEmpty(const Hits& hits, std::vector<std::uint8_t>& reasons) {
  const auto beamOf = [&](std::size_t ray) {
    return hits.beamOfRay.empty() ? static_cast<std::uint32_t>(ray) : hits.beamOfRay[ray];
  };
  for (std::size_t ray = 0; ray < hits.pathOfRay.size(); ++ray) {
    std::uint8_t& reason = reasons[beamOf(ray)];
    const bool blocked = hits.pathOfRay[ray] == RayPath::OwnVehicle && !hits.hit(ray);
    if (blocked && reason == 0) reason = static_cast<std::uint8_t>(Reason::BlockedByVehicle);
  }
  for (const std::uint32_t ray : hits.unresolved) {
    std::uint8_t& reason = reasons[beamOf(ray)];
    if (reason == 0) reason = static_cast<std::uint8_t>(Reason::GivenUp);
  }
  for (std::uint8_t& reason : reasons) {
    if (reason == 0) reason = static_cast<std::uint8_t>(Reason::NothingInRange);
  }
}

}  // namespace

Channels channelsFor(EffectList effects, ColumnSet columns) {
  Channels channels = Channels(Channel::Range) | columns.channels();
  for (const auto& effect : effects) channels |= effect->reads();
  return channels;
}

void detect(const Hits& hits, const Shot& shot, EffectList effects, std::span<const Material> materials,
            Returns& returns) {
  returns.falloff = {};
  returns.threshold = 0;
  for (const auto& effect : effects) {
    returns.falloff = effect->falloff().value_or(returns.falloff);
    if (effect->threshold() > 0) returns.threshold = effect->threshold();
  }
  if (hits.beamOfRay.empty()) return returns.start(hits);
  std::vector<float> power;
  const bool powered = std::any_of(effects.begin(), effects.end(),
                                   [&](const auto& effect) { return effect->powerOfRays(hits, materials, power); });
  returns.start(findEchoes(hits, power, pulseLength(shot.beams->pulse)), powered);
}

void sense(const Receiver& receiver, const Hits& hits, const Shot& shot, Returns& returns, Scan& scan) {
  const auto& [effects, materials, layout, motions] = receiver;
  checkHits(hits, shot, channelsFor(effects, layout.columns));
  detect(hits, shot, effects, materials, returns);
  if (layout.reasons) returns.tellReasons();
  for (const auto& effect : effects) effect->apply(hits, shot, materials, returns);
  gather(hits, shot, returns, layout, motions, scan);
  scan.reasonOfBeam.clear();
  if (layout.reasons) scan.reasonOfBeam = reasonsOf(hits, materials, returns);
}

std::vector<std::uint8_t> reasonsOf(const Hits& hits, std::span<const Material> materials, const Returns& returns) {
  if (!returns.tellsReasons()) throw Error("the table of returns has no reasons");
  std::vector<std::uint8_t> reasons(hits.size(), 0);
  std::vector<std::uint32_t> told(hits.size(), kNoHit);  // for each beam, the row that its reason comes from so far
  for (std::uint32_t row = 0; row < returns.size(); ++row) {
    const bool returned = returns.returned(row);
    const Reason lost = returns.lostTo(row);
    if (!returned && lost == Reason::None) continue;        // the row's ray missed
    if (!returned && returns.hit(row) == kNoHit) continue;  // a lost row that an effect had added, such as a raindrop
    const std::uint32_t beam = returns.beam(row);
    const std::uint32_t other = told[beam];
    const auto power = [&](std::uint32_t r) { return returns.power.empty() ? 0.0f : returns.power[r]; };
    if (other != kNoHit) {
      const bool otherReturned = returns.returned(other);
      if (otherReturned && !returned) continue;
      if (otherReturned && returns.range[other] <= returns.range[row]) continue;
      if (!otherReturned && !returned && power(other) >= power(row)) continue;
    }
    told[beam] = row;
    const Reason reason = returned                   ? static_cast<Reason>(returns.cause(row))
                          : lost == Reason::TooFaint ? ofFaint(hits, materials, returns.hit(row))
                                                     : lost;
    reasons[beam] = static_cast<std::uint8_t>(reason);
  }
  fillEmpty(hits, reasons);
  return reasons;
}

}  // namespace scanmill
