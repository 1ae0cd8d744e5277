#pragma once

// Interprets the names of members and samples.

#include <cstddef>
#include <string>
#include <vector>

namespace scanmill {

// The parts of a member's name such as "dir/key.top.ray_tracing.pcd". As in WebDataset, the key ends at the first dot
// of the file's name. A part that the name does not have is empty.
struct MemberName {
  std::string key;
  std::string sensor;
  std::string method;
  std::string suffix;  // suffix of the format
};
MemberName partsOfMember(const std::string& member);

// Returns the text with the letters A to Z in lower case. Members' names are in lower case even if the sensor's name is
// not.
[[nodiscard]] std::string lowerCase(std::string text);

// Returns the index of the key that `wanted` specifies: the full key, an index from 0 ("12", "#12"), or a part of
// exactly one key. If `wanted` is empty, returns the index of the middle key. Throws an InputError that lists the most
// similar keys and names the dataset as `where`.
std::size_t findKey(const std::vector<std::string>& keys, const std::string& wanted, const std::string& where);

}  // namespace scanmill
