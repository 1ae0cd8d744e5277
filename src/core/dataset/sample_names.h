#pragma once

// Reads the names of members and samples.

#include <cstddef>
#include <string>
#include <vector>

namespace scanmill {

// The parts of a member's name such as "dir/key.top.ray_tracing.pcd": WebDataset's key ends at the first dot of the
// file's name. Parts that a name lacks are empty.
struct MemberName {
  std::string key;
  std::string sensor;
  std::string method;
  std::string suffix;  // the format's
};
MemberName partsOfMember(const std::string& member);

// The text with the letters A to Z in lower case. Members are named in lower case, whatever the sensor's name.
std::string lowerCase(std::string text);

// The index of the key that is `wanted`: the whole key, its index from 0 ("12", "#12"), or a part that no other key
// has; where `wanted` is empty, the middle key. Throws InputError with the nearest keys; `where` names the dataset in
// it.
std::size_t findKey(const std::vector<std::string>& keys, const std::string& wanted, const std::string& where);

}  // namespace scanmill
