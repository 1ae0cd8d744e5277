#pragma once

// The folder that a dataset is written into.

#include <filesystem>

namespace scanmill {

// Creates `folder`. One that holds files is an InputError, unless `overwrite`: then the manifest goes first, durably,
// so that from there on nothing looks finished; then the shards that it lists (without a manifest: what has a shard's
// name), and temporary files of killed runs. Files of others beside a dataset stay. Where one would be in a shard's
// way, where there are others without a dataset, or where the manifest is not ours, it is an InputError and nothing is
// removed.
void prepareOutputFolder(const std::filesystem::path& folder, bool overwrite);

}  // namespace scanmill
