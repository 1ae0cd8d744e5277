#pragma once

// A decoded scan against what the manifest says of it.

#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

// One line for each thing that is wrong; empty: the scan is sound. `maxError` (m) is the format's. `record` is a scan
// of the manifest: its sensor is there.
std::vector<std::string> checkScan(const Scan& scan, const ScanRecord& record, const Manifest& manifest,
                                   double maxError);

}  // namespace scanmill
