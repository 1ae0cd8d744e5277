#pragma once

// The charts of a dataset's report.

#include <string>
#include <vector>

#include "charts/chart.h"
#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"

namespace scanmill {

// Returns all charts of the report; a chart without data has no points.
std::vector<Chart> datasetCharts(const Manifest& manifest, const DatasetSummary& summary);

// Returns a colour as "#rrggbb".
std::string htmlColor(const Rgb& color);

// A ring of distance around the sensor: a whole number of the summary's steps. The rings are few enough for a table or
// a bar chart, and reach to the last step that holds points.
struct DistanceRing {
  std::string name;                 // "20 to 30 m"
  std::size_t first = 0, last = 0;  // steps, [first, last)
};
std::vector<DistanceRing> distanceRings(const DatasetSummary& summary);
// Returns the number of points in a ring, from the numbers per step.
std::uint64_t pointsIn(const std::vector<std::uint64_t>& ranges, const DistanceRing& ring);

}  // namespace scanmill
