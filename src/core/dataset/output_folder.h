#pragma once

// The folder that a dataset is written into.

#include <filesystem>

namespace scanmill {

// Makes `folder` ready for a dataset: creates it, or, with `overwrite`, removes the dataset that is in it. The manifest
// is removed first and for good, so that what is left of the folder never looks finished; then the shards that it lists
// (without a manifest, all files that have a shard's name) and the temporary files of runs that were killed. Files of
// others that lie beside a dataset stay.
//
// Throws an InputError, and removes nothing, where the folder holds files and `overwrite` is false, where a file of
// others has the name that a shard would get, where files of others lie there without a dataset, and where the manifest
// was not written by this program.
void prepareOutputFolder(const std::filesystem::path& folder, bool overwrite);

}  // namespace scanmill
