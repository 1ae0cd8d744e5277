#pragma once

// Writes the tables of a dataset's report as HTML; a table is empty where there is nothing to show.

#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"
#include "report/dataset/object_counts.h"

namespace scanmill {

std::string classesOverview(const DatasetSummary& summary);
std::string distancesOverview(const DatasetSummary& summary);
// Why beams have returns or none, by sensor; empty where the dataset does not say.
std::string reasonsOverview(const DatasetSummary& summary);
// How much of the listed objects sensors see; empty where the dataset lists none.
std::string objectsOverview(const Manifest& manifest, const ObjectCounts& counts);
std::string sensorsOverview(const Manifest& manifest, const DatasetSummary& summary);
std::string sequencesOverview(const DatasetSummary& summary);
std::string splitsOverview(const DatasetSummary& summary);
// `faults` has an entry per shard, which is empty where the shard is sound.
std::string shardsOverview(const Manifest& manifest, const std::vector<std::string>& faults);
std::string columnsOverview(const Manifest& manifest);
std::string formatsOverview(const Manifest& manifest);
// Instances with several classes; those whose classes usually go together are only counted.
std::string mixedInstances(const DatasetSummary& summary);

}  // namespace scanmill
