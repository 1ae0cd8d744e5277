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
  std::optional<Ontology> ontology;  // from the dataset's manifest or the folder's layout; none: unknown
};

// Finds and decodes a scan. `path` is a dataset's folder, a shard, a folder of recorded scans, or one scan in any known
// format. In a dataset or a shard, `sample` is a key, an index from 0, or a part of exactly one key; if it is empty,
// the middle sample is taken. `sensor` names one of the sample's sensors; if it is empty, the first is taken. If a
// sample holds a scan in several formats, the first that can be decoded is taken. The manifest of a shard is searched
// beside and above it; a shard without a manifest can be read, too. Throws InputError for a file of unknown kind, an
// unknown sample (with the nearest keys), an unknown sensor (with the known ones), and if a sample or a sensor is given
// for a single scan.
ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor);

}  // namespace scanmill
