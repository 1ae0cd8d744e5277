#pragma once

// The member `<key>.json`, which is the first member of each sample in a shard.

#include <string>
#include <string_view>

#include "dataset/manifest.h"

namespace scanmill {

// Returns the member's text: key, sequence, frame, split, time (of the first scan) and the poses and counts of the
// scans. Class ids are those of the manifest's ontology. The record's shard and members are left out.
std::string sampleJson(const SampleRecord& sample);

// Returns the first difference between a member's text and the record ("/scans/0/points is 11, not 12"), or a message
// that the text is not JSON. Empty if text and record agree.
std::string differenceOfSampleJson(std::string_view text, const SampleRecord& sample);

// The parts of a key: "street-s1-drive-000004" is frame "000004" of the sequence "street-s1-drive". Both are empty if
// the key does not end in a number.
struct KeyParts {
  std::string sequence;
  std::string frame;
};
KeyParts partsOfKey(const std::string& key);

}  // namespace scanmill
