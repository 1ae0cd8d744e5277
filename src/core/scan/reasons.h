#pragma once

// The reason of a beam: what its return comes from, or why it has none.

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>

namespace scanmill {

// A value below 16 is also the column `cause` of the beam's nearest return.
enum class Reason : std::uint8_t {
  None = 0,  // not known yet
  Surface = 1,
  FalsePositive = 2,
  ThroughGlass = 3,
  Mirrored = 4,
  OwnVehicle = 5,
  Weather = 6,
  StrayLight = 7,
  NothingInRange = 16,
  BlockedByVehicle = 17,
  TooFaint = 18,
  MirroredAway = 19,
  LostInGlass = 20,
  LostInAir = 21,
  Dropped = 22,
  GivenUp = 23,
};

struct ReasonEntry {
  Reason reason;
  std::string_view name;
  std::string_view meaning;
  std::array<std::uint8_t, 3> color;  // sRGB
};

// Returns the rows of all reasons except None; those of beams with a return come first.
std::span<const ReasonEntry> reasons();
// Returns null if no row has the value.
const ReasonEntry* findReason(std::uint8_t value);
// Returns null if no row has this name.
const ReasonEntry* findReason(std::string_view name);

// How many beams have each reason; reasons without beams are left out.
using ReasonCounts = std::map<std::uint8_t, std::uint64_t>;
ReasonCounts countReasons(std::span<const std::uint8_t> reasonOfBeam);

}  // namespace scanmill
