#pragma once

// Describes the samples of a shard from the shard's members.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

// Returns the records of a shard's samples, as in a complete manifest, in the order of the shard. Throws an InputError
// if the shard is damaged.
std::vector<SampleRecord> samplesOfShard(const std::filesystem::path& folder, const Manifest& manifest,
                                         std::uint32_t shard);

}  // namespace scanmill
