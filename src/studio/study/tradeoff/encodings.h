#pragma once

// Measures the time, size and error of encoding scans.

#include <span>

#include "scan/scan.h"
#include "study/tradeoff/settings.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// Encodes and decodes each scan `repeats` times on one thread and uses the shortest time of each scan. Rates and sizes
// are per return; misses in organised scans need bytes, but do not count as points. The error is the distance between
// decoded and original positions.
EncodingResult measureEncoding(const StudyEncoding& encoding, std::span<const Scan> scans, int repeats);

}  // namespace scanmill
