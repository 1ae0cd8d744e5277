#pragma once

// Compares a decoded scan with its record in the manifest.

#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

// Returns one line for each fault; none for a sound scan. `record`: the scan's record in the manifest, which must list
// the record's sensor. `maxError`: largest error of a position in the scan's format (m).
[[nodiscard]] std::vector<std::string> checkScan(const Scan& scan, const ScanRecord& record, const Manifest& manifest,
                                                 double maxError);

}  // namespace scanmill
