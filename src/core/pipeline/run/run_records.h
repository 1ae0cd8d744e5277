#pragma once

// What a dataset's manifest says of a run and its scans.

#include <string_view>

#include "dataset/manifest.h"
#include "dataset/parts.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "sensors/shot.h"

namespace scanmill {

// All that is known before the first ray.
Manifest startManifest(const Plan& plan, const DatasetPlan& planned);

// A scan's place, time and counts.
ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method);

}  // namespace scanmill
