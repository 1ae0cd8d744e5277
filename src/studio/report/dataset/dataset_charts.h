#pragma once

// Draws the charts of a dataset's report as SVG; a chart is empty where there is nothing to show.

#include <string>

#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"

namespace scanmill {

std::string classPointsChart(const DatasetSummary& summary);
std::string classObjectsChart(const DatasetSummary& summary);
std::string splitSharesChart(const DatasetSummary& summary);  // shares of the classes, where there are several splits
std::string ringPointsChart(const DatasetSummary& summary);   // points per ring of distance, by class
std::string ringSharesChart(const DatasetSummary& summary);   // shares of the classes in each ring of distance
std::string rangesChart(const DatasetSummary& summary);
std::string intensitiesChart(const DatasetSummary& summary);
std::string scanPointsChart(const Manifest& manifest);  // one scan after the other

// A colour as "#rrggbb".
std::string htmlColor(const Rgb& color);

// A ring of distance around the sensor: a whole number of the summary's steps. There are as few rings as a table or a
// chart with bars can show, up to the last one that holds points.
struct DistanceRing {
  std::string name;                 // "20 to 30 m"
  std::size_t first = 0, last = 0;  // steps, [first, last)
};
std::vector<DistanceRing> distanceRings(const DatasetSummary& summary);

}  // namespace scanmill
