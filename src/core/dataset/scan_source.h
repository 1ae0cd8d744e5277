#pragma once

// Finds and decodes the scan that a user names.

#include <filesystem>
#include <optional>
#include <string>

#include "scan/scan.h"
#include "scene/ontology.h"

namespace scanmill {

struct ScanSource {
  Scan scan;
  std::string title;                 // "street-s1-lane-000010, top"
  std::optional<Ontology> ontology;  // of the dataset's manifest or the folder's layout, where there is one
};

// `path` is a dataset's folder, a shard, a folder of recorded scans, or one scan of any known format. In a dataset or a
// shard, `sample` is a key, an index from 0, or a part that only one key has; where it is empty, the middle sample is
// taken. `sensor` names one of the sample's sensors; where it is empty, the first is taken. Where a sample holds a scan
// in several formats, the first one that can be decoded is taken. The manifest of a shard is looked for beside and
// above it; a shard without one is read, too. Throws InputError for a file of no known kind, a sample that is not there
// (with the nearest keys), a sensor that is not there (with those that are), and a sample or sensor where `path` is a
// single scan.
ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor);

}  // namespace scanmill
