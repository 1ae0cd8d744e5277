#pragma once

// The reason of a beam: what its return comes from, or why it has no return. This header is installed because
// dataset/manifest.h includes it.
//
//   for (const auto& [reason, beams] : countReasons(scan.reasonOfBeam)) {
//     std::printf("%s: %llu\n", findReason(reason)->name.data(), static_cast<unsigned long long>(beams));
//   }

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>

namespace scanmill {

// A reason below 16 is also the value of the column `cause` for the beam's nearest return.
enum class Reason : std::uint8_t {
  None = 0,  // not determined yet
  Surface = 1,
  FalsePositive = 2,
  ThroughGlass = 3,
  Mirrored = 4,
  EgoVehicle = 5,
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
  std::array<std::uint8_t, 3> color;  // sRGB, colour of the reason in pictures
};

// Returns the rows of all reasons except None; reasons of beams with a return come first.
std::span<const ReasonEntry> reasons();
// Returns the row with this value; null if there is none.
const ReasonEntry* findReason(std::uint8_t value);
// Returns the row with this name; null if there is none.
const ReasonEntry* findReason(std::string_view name);

// Number of beams by the value of their reason; reasons without beams are left out.
using ReasonCounts = std::map<std::uint8_t, std::uint64_t>;
ReasonCounts countReasons(std::span<const std::uint8_t> reasonOfBeam);

}  // namespace scanmill
