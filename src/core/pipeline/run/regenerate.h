#pragma once

// Recreates parts of a dataset from its manifest, byte for byte.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns the indices of the shards that are missing, or whose bytes differ from the hashes in the manifest.
std::vector<std::uint64_t> damagedShards(const std::filesystem::path& folder, const Manifest& manifest);

// Recreates shards, given by index, and the files that describe their samples, and moves them into the folder, where
// they replace existing files. `manifest`: see readManifest() for damaged files; `plan`: see planOfDataset(). Throws
// Error if new bytes differ from the hash in the manifest, because the program or a file that the pipeline names has
// changed; then nothing is replaced.
void regenerateShards(const std::filesystem::path& folder, Manifest manifest, const Plan& plan,
                      const std::vector<std::uint64_t>& shards, bool quiet, const std::atomic<bool>* stop);

}  // namespace scanmill
