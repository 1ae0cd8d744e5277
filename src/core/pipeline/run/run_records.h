#pragma once

// What a dataset's manifest says of a run and its scans.

#include <string_view>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "sensors/shot.h"

namespace scanmill {

// All that is known before the first ray.
Manifest startManifest(const Plan& plan);

// A scan's place, time and counts.
ScanRecord recordOf(const Shot& shot, const Hits& hits, const Scan& scan, std::string_view method);

// A text that differs where datasets of plans would differ: of the program's version, the pipeline and the chosen
// method, the sensors' beams, and the files that it names as scenes. Assets, ontologies and materials are not read:
// whoever changes one begins anew.
std::string planHash(const Plan& plan);

}  // namespace scanmill
