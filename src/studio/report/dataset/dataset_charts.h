#pragma once

// Makes the charts of a dataset's report.

#include <string>
#include <vector>

#include "charts/chart.h"
#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"

namespace scanmill {

// Returns all charts of the report. If there are no data for a chart, it has no points.
std::vector<Chart> datasetCharts(const Manifest& manifest, const DatasetSummary& summary);

// Returns a colour as "#rrggbb".
std::string htmlColor(const Rgb& color);

// A ring of distances around the sensor, which consists of consecutive steps of DatasetSummary::steps. There are few
// enough rings for a table or a bar chart; together they reach to the last step with points.
struct DistanceRing {
  std::string name;                 // the ring's distances, such as "20 to 30 m"
  std::size_t first = 0, last = 0;  // indices of steps; `last` is excluded
};
std::vector<DistanceRing> distanceRings(const DatasetSummary& summary);
// Returns the number of points in a ring. `ranges`: number of points in each of DatasetSummary::steps.
std::uint64_t pointsIn(const std::vector<std::uint64_t>& ranges, const DistanceRing& ring);

}  // namespace scanmill
