#pragma once

// The file beside a manifest that describes the dataset for people: the data card.

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "dataset/manifest.h"
#include "dataset/names.h"

namespace scanmill {

// Returns the data card in Markdown: the dataset's contents, how it was made, and its suitable and unsuitable uses, as
// proposed by Gebru et al., "Datasheets for Datasets" (Communications of the ACM 64, 2021).
std::string cardText(const Manifest& manifest);

// Counts over all scans of a dataset.
struct ScanTotals {
  std::uint64_t points = 0;
  std::uint64_t beams = 0;
  std::uint64_t unresolved = 0;                          // beams that the method could not trace
  std::map<std::uint16_t, std::uint64_t> perClass;       // points
  std::map<std::string, std::set<std::string>> methods;  // names of methods, by sensor
};
ScanTotals totalsOf(const Manifest& manifest);

struct Span {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
};
// Returns an interval as "1.2 to 1.4", to four decimals; as one number if both ends have the same text.
std::string spanText(const Span& span);

// Returns the intervals of x, y, z (m), yaw, pitch and roll (degrees) of a sensor's mounts in all scans. The two ends
// of an interval are equal unless the mount is random.
using MountSpans = std::array<Span, 6>;
MountSpans mountSpans(const Manifest& manifest, const SensorRecord& sensor);

}  // namespace scanmill
