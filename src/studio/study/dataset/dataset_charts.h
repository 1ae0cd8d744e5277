#pragma once

// The charts of a dataset's report: SVG, or empty where there is nothing to show.

#include <string>

#include "dataset/manifest.h"
#include "study/dataset/dataset_summary.h"

namespace scanmill {

std::string classPointsChart(const DatasetSummary& summary);
std::string classObjectsChart(const DatasetSummary& summary);
std::string splitSharesChart(const DatasetSummary& summary);  // of classes, where there are several splits
std::string ringPointsChart(const DatasetSummary& summary);   // points per ring of distance, by class
std::string ringSharesChart(const DatasetSummary& summary);   // classes in each of them
std::string rangesChart(const DatasetSummary& summary);
std::string intensitiesChart(const DatasetSummary& summary);
std::string scanPointsChart(const Manifest& manifest);  // one scan after the other

// "#rrggbb".
std::string htmlColor(const Rgb& color);

// Rings of distance that a table or a chart of few bars can show: whole numbers of the summary's steps, up to the
// last one that holds points.
struct DistanceRing {
  std::string name;                 // "20 to 30 m"
  std::size_t first = 0, last = 0;  // steps, [first, last)
};
std::vector<DistanceRing> distanceRings(const DatasetSummary& summary);

}  // namespace scanmill
