#pragma once

// Creates a dataset's manifest and the records of its scans.

#include <string_view>

#include "dataset/manifest.h"
#include "dataset/parts.h"
#include "pipeline/scenes/shot_source.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns a manifest with everything that is known before the first ray is traced.
Manifest startManifest(const ShotSource& source, const DatasetPlan& planned);

// Returns the manifest's record of a scan: its poses, time and counts.
ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method);

}  // namespace scanmill
