#pragma once

// Finds and decodes a scan that a user specifies.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

struct ScanSource {
  Scan scan;
  std::string title;                       // for example "street-s1-lane-000010, top"
  std::shared_ptr<const BeamTable> beams;  // beam table of the sensor; null if unknown
  std::optional<Ontology> ontology;        // from the dataset's manifest or the folder's layout; none: unknown classes
};

// Finds and decodes a scan. `path`: a dataset's folder, a shard, a folder of recorded scans, or a single scan in any
// known format. `sample`: in a dataset or a shard, a key, an index from 0, or a part of exactly one key; if empty, the
// middle sample. `sensor`: name of one of the sample's sensors; if empty, the first. If a sample contains a scan in
// several formats, the first format that can be decoded is used. The manifest of a shard is searched for in the
// shard's folder and the folder above it; a shard without a manifest can also be read. Throws InputError for a file of
// unknown kind, an unknown sample (with the most similar keys), an unknown sensor (with the known sensors), and if a
// sample or a sensor is given for a single scan.
ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor);

}  // namespace scanmill
