#pragma once

// The JSON member that opens each sample: `<key>.json`.

#include <string>
#include <string_view>

#include "dataset/manifest.h"

namespace scanmill {

// Key, sequence, frame, split, time (of the first scan) and the scans' poses and counts; class ids are those of the
// manifest's ontology. The record's shard and members do not matter.
std::string sampleJson(const SampleRecord& sample);

// Where `text` departs from the record ("/scans/0/points is 11, not 12"), or why it is no JSON; empty where they agree.
std::string differenceOfSampleJson(std::string_view text, const SampleRecord& sample);

// A key is sequence-frame: "street-1-drive-000004" is frame 000004 of "street-1-drive". Both are empty for a key that
// does not end in a number.
struct KeyParts {
  std::string sequence;
  std::string frame;
};
KeyParts partsOfKey(const std::string& key);

}  // namespace scanmill
