#pragma once

// Recreates parts of a dataset from its manifest, byte for byte.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// Returns the indices of the shards that are missing, or whose bytes differ from the hashes in the manifest.
std::vector<std::uint64_t> damagedShards(const std::filesystem::path& folder, const Manifest& manifest);

// Recreates shards, given by index, and moves them into the folder, where they replace existing files. `plan`: see
// planOfDataset(). Throws Error if the bytes of a new shard differ from the hash in the manifest, because the program
// or a file that the pipeline names has changed; then nothing is replaced.
void regenerateShards(const std::filesystem::path& folder, const Manifest& manifest, const Plan& plan,
                      const std::vector<std::uint64_t>& shards, bool quiet, const std::atomic<bool>* stop);

// Makes the files again that describe the samples of shards, given by index, from these shards, which must be sound,
// and adds the samples to the manifest. `manifest`: see readManifest() for damaged files. The samples' numbers usually
// follow from the samples that the manifest describes; otherwise plan() is called, see planOfDataset(). Writes each
// file whose bytes have the hash in the manifest, and throws Error if others remain.
void describeShards(const std::filesystem::path& folder, Manifest& manifest, const std::vector<std::uint64_t>& shards,
                    const std::function<Plan()>& plan);

// Recreates the sample `key`, writes its members as files into the folder `into`, which is created, and returns the
// file names. Throws InputError for a key that the manifest does not list, and Error if bytes differ from the XXH3
// hashes in the manifest. If the manifest has no such hashes, bytes are not compared.
std::vector<std::string> regenerateSample(const Manifest& manifest, const Plan& plan, const std::string& key,
                                          const std::filesystem::path& into);

}  // namespace scanmill
