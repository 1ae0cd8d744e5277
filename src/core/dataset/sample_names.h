#pragma once

// Reads the names of members and samples.

#include <cstddef>
#include <string>
#include <vector>

namespace scanmill {

// The parts of a member's name such as "dir/key.top.ray_tracing.pcd". As in WebDataset, the key ends at the first dot
// of the file's name. Parts that a name lacks are empty.
struct MemberName {
  std::string key;
  std::string sensor;
  std::string method;
  std::string suffix;  // the suffix of the format
};
MemberName partsOfMember(const std::string& member);

// Returns the text with the letters A to Z in lower case. Members' names are in lower case, whatever the sensor's name.
std::string lowerCase(std::string text);

// Returns the index of the key that `wanted` names: by the full key, its index from 0 ("12", "#12"), or a part that no
// other key has. If `wanted` is empty, returns that of the middle key. Throws an InputError with the nearest keys, in
// which `where` names the dataset.
std::size_t findKey(const std::vector<std::string>& keys, const std::string& wanted, const std::string& where);

}  // namespace scanmill
