#include "sense/sense.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "sense/echoes.h"
#include "sense/gather.h"
#include "sense/reasons.h"
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

}  // namespace scanmill
