#pragma once

// Datasets whose samples are described in files beside the shards, as those of very large datasets are.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/file.h"
#include "base/hash.h"
#include "dataset/manifest.h"
#include "dataset/names.h"

namespace scanmill {

// Moves the descriptions of all samples from a dataset's manifest into files beside the shards.
inline void describeBesideShards(const std::filesystem::path& folder) {
  Manifest manifest = readManifest(folder);
  for (std::uint32_t shard = 0; shard < manifest.shards.size(); ++shard) {
    std::vector<std::uint64_t> numbers;
    for (std::uint64_t i = 0; i < manifest.samples.size(); ++i) {
      if (manifest.samples[i].shard == shard) numbers.push_back(i);
    }
    const std::string text = samplesJson(manifest, shard, numbers);
    writeFile(folder / samplesFileOf(manifest.shards[shard].file), text);
    manifest.shards[shard].samplesSha256 = sha256(text);
  }
  manifest.samples.clear();
  writeFile(folder / kManifestName, toJson(manifest));
}

}  // namespace scanmill
