#pragma once

// Makes parts of a dataset again, byte for byte, from its manifest.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns the numbers of the shards that are missing, or whose bytes differ from what the manifest states.
std::vector<std::uint64_t> damagedShards(const std::filesystem::path& folder, const Manifest& manifest);

// Makes shards again and puts them into the folder, where they replace existing files. `plan`: see planOfDataset().
// Throws Error if a new shard has other bytes than the manifest states, because the program or a file that the pipeline
// names has changed; then nothing is replaced.
void regenerateShards(const std::filesystem::path& folder, const Manifest& manifest, const Plan& plan,
                      const std::vector<std::uint64_t>& shards, bool quiet, const std::atomic<bool>* stop);

// Makes a sample again, writes its members as files into a folder, which is created, and returns their names. Throws
// InputError for a key that the manifest does not list, and Error for other bytes than the manifest states. Bytes are
// not compared if the manifest has no XXH3 of them.
std::vector<std::string> regenerateSample(const Manifest& manifest, const Plan& plan, const std::string& key,
                                          const std::filesystem::path& into);

}  // namespace scanmill
