#include "sense/reasons.h"

#include "base/error.h"

namespace scanmill {

namespace {

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
