#pragma once

// Completes a dataset whose shards were written by several processes.

#include <filesystem>

#include "dataset/manifest.h"

namespace scanmill {

// Joins the parts in a folder, writes the manifest, and returns it. If the dataset is already complete, only returns
// its manifest. Shards are checked by their records and sizes, but not read; verifyDataset() reads them. Throws
// InputError if shards are missing (with their numbers), if parts belong to another plan, or if a process is writing
// into the folder. Throws Error if a sample occurs twice or the disk fails.
Manifest mergeDataset(const std::filesystem::path& folder);

}  // namespace scanmill
