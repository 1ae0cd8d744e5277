#pragma once

// The charts of a dataset's report.

#include <string>
#include <vector>

#include "charts/chart.h"
#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"

namespace scanmill {

// All of them, by name; those without anything to show have no points.
std::vector<Chart> datasetCharts(const Manifest& manifest, const DatasetSummary& summary);

// A colour as "#rrggbb".
std::string htmlColor(const Rgb& color);

// A ring of distance around the sensor: a whole number of the summary's steps. There are as few rings as a table or a
// chart with bars can show, up to the last one that holds points.
struct DistanceRing {
  std::string name;                 // "20 to 30 m"
  std::size_t first = 0, last = 0;  // steps, [first, last)
};
std::vector<DistanceRing> distanceRings(const DatasetSummary& summary);
// Of points per step.
std::uint64_t pointsIn(const std::vector<std::uint64_t>& ranges, const DistanceRing& ring);

}  // namespace scanmill
