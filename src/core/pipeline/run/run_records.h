#pragma once

// Makes the records of a run and of its scans for a dataset's manifest.

#include <string_view>

#include "dataset/manifest.h"
#include "dataset/parts.h"
#include "pipeline/scenes/shot_source.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns a manifest with all that is known before the first ray is traced.
Manifest startManifest(const ShotSource& source, const DatasetPlan& planned);

// Returns the poses, time and counts of a scan.
ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method);

}  // namespace scanmill
