#pragma once

// Finds the scan that somebody wants to see.

#include <filesystem>
#include <optional>
#include <string>

#include "scan/scan.h"
#include "scene/ontology.h"

namespace scanmill {

struct ScanSource {
  Scan scan;
  std::string title;                 // "street-s1-lane-000010, top"
  std::optional<Ontology> ontology;  // of the dataset's manifest
};

// `path` is a dataset's folder, a shard, or one scan of any known format. In a dataset or a shard `sample` is a key or
// an index from 0, or part of one key alone, empty for the middle one; `sensor` is empty for the sample's first. Where
// a sample holds a scan in several formats, the first that can be decoded is taken. A shard finds its manifest beside
// or above it, and does without. Throws InputError: no such sample (with the nearest keys), no such sensor (with those
// that are there), a sample or sensor of a single scan, a file of no known kind.
ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor);

}  // namespace scanmill
