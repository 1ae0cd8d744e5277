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

// Numbers of the shards that are missing, or whose bytes are not those that the manifest states.
std::vector<std::uint64_t> damagedShards(const std::filesystem::path& folder, const Manifest& manifest);

// Makes shards again and puts them in their places, in place of what is there. `plan`: see planOfDataset(). Throws
// Error where one comes out with other bytes than the manifest states, since the program or what the pipeline names has
// changed; then nothing is replaced.
void regenerateShards(const std::filesystem::path& folder, const Manifest& manifest, const Plan& plan,
                      const std::vector<std::uint64_t>& shards, bool quiet, const std::atomic<bool>* stop);

// Makes a sample again and writes its members as files into a folder, which is created. Returns their names. Throws
// InputError for a key that the manifest does not list, and Error as above; the bytes of datasets whose manifests have
// no XXH3 cannot be compared.
std::vector<std::string> regenerateSample(const Manifest& manifest, const Plan& plan, const std::string& key,
                                          const std::filesystem::path& into);

}  // namespace scanmill
