#pragma once

// Ends a dataset whose shards were made by several processes.

#include <filesystem>

#include "dataset/manifest.h"

namespace scanmill {

// Joins the parts in a folder, writes the manifest, and returns it; of a dataset that is whole already, its manifest
// alone. Shards are checked by their records and sizes, not read again: verify() reads them. Throws InputError for
// shards that are missing, with their numbers, for parts of another plan, and where processes write into the folder;
// Error for doubles, and where the disk fails.
Manifest mergeDataset(const std::filesystem::path& folder);

}  // namespace scanmill
