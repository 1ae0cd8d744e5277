#pragma once

// Measures the time, size and loss of each encoding of a scan.

#include <span>
#include <vector>

#include "scan/scan.h"
#include "study/tradeoff/settings.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// Encodes and decodes all scans, one after the other on one thread, `repeats` times; the shortest time of each scan
// counts. Points are returns: misses in an organised scan cost bytes, but do not count as points. Errors compare the
// decoded positions with the originals, point by point.
EncodingResult measureEncoding(const StudyEncoding& encoding, std::span<const Scan> scans, int repeats);

}  // namespace scanmill
