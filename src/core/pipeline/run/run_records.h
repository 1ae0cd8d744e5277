#pragma once

// What a dataset's manifest says of a run and its scans.

#include <string_view>

#include "dataset/manifest.h"
#include "dataset/parts.h"
#include "pipeline/scenes/shot_source.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns all that is known before the first ray.
Manifest startManifest(const ShotSource& source, const DatasetPlan& planned);

// A scan's place, time and counts.
ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method);

}  // namespace scanmill
