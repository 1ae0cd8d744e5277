#include "scan/reasons.h"

#include <algorithm>

namespace scanmill {

std::span<const ReasonEntry> reasons() {
  static constexpr std::array<ReasonEntry, 15> kReasons{{
      {Reason::Surface, "surface", "returns from a surface of the scene", {110, 140, 160}},
      {Reason::ThroughGlass, "through_glass", "returns from a surface behind glass", {90, 200, 210}},
      {Reason::Mirrored, "mirrored", "returns from the mirror image of a surface", {190, 120, 220}},
      {Reason::EgoVehicle, "own_vehicle", "returns from the vehicle that carries the sensor", {120, 160, 70}},
      {Reason::Weather, "weather", "returns from rain, snow, fog or dust", {235, 235, 235}},
      {Reason::StrayLight,
       "stray_light",
       "returns from light beside the beam: a bright target's, or another sensor's",
       {255, 170, 200}},
      {Reason::FalsePositive, "false_positive", "returns from nothing: noise of the receiver", {255, 80, 200}},
      {Reason::NothingInRange, "nothing_in_range", "meets nothing within the sensor's range", {20, 24, 32}},
      {Reason::BlockedByVehicle,
       "blocked_by_vehicle",
       "hits the own vehicle, whose returns are dropped or which is nearer than the sensor's least range",
       {60, 80, 35}},
      {Reason::TooFaint, "too_faint", "what it hits returns less than the receiver can detect", {200, 50, 40}},
      {Reason::MirroredAway,
       "mirrored_away",
       "the same, and what it meets is a mirror or a metal, which sends light elsewhere",
       {240, 150, 40}},
      {Reason::LostInGlass,
       "lost_in_glass",
       "passes a pane, and what lies behind sends back too little",
       {40, 90, 170}},
      {Reason::LostInAir, "lost_in_air", "would be found but for what the weather takes", {150, 150, 110}},
      {Reason::Dropped, "dropped", "lost at random, by the effect dropout", {250, 220, 60}},
      {Reason::GivenUp, "given_up", "the method gave the beam up: neither hit nor miss", {255, 0, 0}},
  }};
  return kReasons;
}

const ReasonEntry* findReason(std::uint8_t value) {
  const auto row = std::ranges::find(reasons(), static_cast<Reason>(value), &ReasonEntry::reason);
  return row == reasons().end() ? nullptr : &*row;
}

const ReasonEntry* findReason(std::string_view name) {
  const auto row = std::ranges::find(reasons(), name, &ReasonEntry::name);
  return row == reasons().end() ? nullptr : &*row;
}

ReasonCounts countReasons(std::span<const std::uint8_t> reasonOfBeam) {
  std::array<std::uint64_t, 256> beams{};  // by value of the reason; counting in an array is faster than in a map
  for (const std::uint8_t value : reasonOfBeam) ++beams[value];
  ReasonCounts counts;
  for (std::size_t value = 0; value < beams.size(); ++value) {
    if (beams[value] > 0) counts[static_cast<std::uint8_t>(value)] = beams[value];
  }
  return counts;
}

}  // namespace scanmill
