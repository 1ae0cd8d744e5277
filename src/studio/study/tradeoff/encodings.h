#pragma once

// Measures what each encoding of a scan takes, and what it loses.

#include <span>
#include <vector>

#include "scan/scan.h"
#include "study/tradeoff/settings.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// Encodes and decodes all scans, one after the other on one thread; the least of `repeats` times of each scan counts.
// Points are returns: an organised scan's misses cost bytes, but are no points. Errors are those of the decoded
// positions, point by point.
EncodingResult measureEncoding(const StudyEncoding& encoding, std::span<const Scan> scans, int repeats);

}  // namespace scanmill
