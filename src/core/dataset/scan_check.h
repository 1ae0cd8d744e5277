#pragma once

// Compares a decoded scan with what the manifest says of it.

#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

// Returns one line for each thing that is wrong, none for a sound scan. `record` is the manifest's of this scan, whose
// sensor the manifest must have; `maxError` is the largest error of a position in the scan's format (m).
std::vector<std::string> checkScan(const Scan& scan, const ScanRecord& record, const Manifest& manifest,
                                   double maxError);

}  // namespace scanmill
