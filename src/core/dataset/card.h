#pragma once

// The descriptions of a dataset that are written beside its manifest, for people and for search engines of datasets.

#include <string>

#include "dataset/manifest.h"
#include "dataset/shard_name.h"

namespace scanmill {

// Returns the data card in Markdown: what the dataset contains, how it was made, what it is for and not for, as asked
// by Gebru et al., "Datasheets for Datasets" (Communications of the ACM 64, 2021).
std::string cardText(const Manifest& manifest);

// Returns the metadata of the dataset as JSON-LD in the format Croissant 1.0 (mlcommons.org/croissant/1.0): its shards
// with their hashes, their members, and a record for each sample with its key, split and description.
std::string croissantJson(const Manifest& manifest);

}  // namespace scanmill
