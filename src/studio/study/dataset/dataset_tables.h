#pragma once

// The tables of a dataset's report: HTML, or empty where there is nothing to show.

#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "study/dataset/dataset_summary.h"

namespace scanmill {

std::string classesOverview(const DatasetSummary& summary);
std::string distancesOverview(const DatasetSummary& summary);
std::string sensorsOverview(const Manifest& manifest, const DatasetSummary& summary);
std::string sequencesOverview(const DatasetSummary& summary);
std::string splitsOverview(const DatasetSummary& summary);
// `faults` are of the shards, empty where sound.
std::string shardsOverview(const Manifest& manifest, const std::vector<std::string>& faults);
std::string columnsOverview(const Manifest& manifest);
std::string formatsOverview(const Manifest& manifest);
std::string stageTimes(const Manifest& manifest);
std::string mixedInstances(const DatasetSummary& summary);  // those that usually go together, counted

}  // namespace scanmill
