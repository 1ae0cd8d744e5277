#include <algorithm>

#include "base/stage_clock.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

double shortestSeconds(int repeats, const auto& work) {
  double shortest = secondsOf(work);
  for (int i = 1; i < repeats; ++i) shortest = std::min(shortest, secondsOf(work));
  return shortest;
}

// Returns the largest distance (m) between points with equal indices. Throws Error if points or misses were lost.
double largestError(const Scan& scan, const Scan& decoded) {
  if (scan.size() != decoded.size()) {
    throw Error("{} of {} points were decoded", decoded.size(), scan.size());
  }
  double largest = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i]) != isFinite(decoded.position[i])) {
      throw Error("point {} {}", i, isFinite(scan.position[i]) ? "was lost" : "was a miss and became a hit");
    }
    if (!isFinite(scan.position[i])) continue;
    largest = std::max(largest, length(Vec3d(decoded.position[i]) - Vec3d(scan.position[i])));
  }
  return largest;
}

}  // namespace

EncodingResult measureEncoding(const StudyEncoding& encoding, std::span<const Scan> scans, int repeats) {
  const Format& format = *encoding.choice.format;
  EncodingResult result{.name = encoding.name,
                        .format = std::string(encoding.choice.entry->name),
                        .options = encoding.options,
                        .statedError = format.maxError()};
  try {
    double encodeSeconds = 0, decodeSeconds = 0, bytes = 0, points = 0;
    for (const Scan& scan : scans) {
      std::string text;
      Scan decoded;
      encodeSeconds += shortestSeconds(repeats, [&] { text = format.encode(scan); });
      decodeSeconds += shortestSeconds(repeats, [&] { decoded = format.decode(text, encoding.name); });
      bytes += static_cast<double>(text.size());
      const Scan returns = withoutMisses(scan);  // formats that cannot store misses decode only these
      points += static_cast<double>(returns.size());
      const bool misses = scan.organised && format.keepsMisses();
      result.largestError = std::max(result.largestError, largestError(misses ? scan : returns, decoded));
    }
    if (points == 0) throw Error("the scans are empty");
    result.encodePointsPerSecond = points / encodeSeconds;
    result.decodePointsPerSecond = points / decodeSeconds;
    result.bytesPerPoint = bytes / points;
  } catch (const Error& error) {
    result.failure = error.what();
  }
  return result;
}

}  // namespace scanmill
