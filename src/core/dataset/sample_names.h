#pragma once

// Interprets the names of members and samples.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scanmill {

// The parts of a member's name such as "dir/key.top.ray_tracing.pcd". As in WebDataset, the key ends at the first dot
// of the file's name. A part that the name does not have is empty.
struct MemberName {
  std::string key{};
  std::string sensor{};
  std::uint32_t revolution = 0;  // "dir/key.top.1.ray_tracing.pcd" is the second revolution of the sensor `top`
  std::string method{};
  std::string suffix{};  // suffix of the format
};
MemberName partsOfMember(const std::string& member);

// The parts of a key: "street-s1-drive-000004" is frame "000004" of the sequence "street-s1-drive". Both are empty if
// the key does not end in a number.
struct KeyParts {
  std::string sequence;
  std::string frame;
};
KeyParts partsOfKey(const std::string& key);

// Returns the index of the key that `query` specifies: the full key, an index from 0 ("12", "#12"), or a part of
// exactly one key. If `query` is empty, returns the index of the middle key. If no key or several match, throws an
// InputError that begins with `where` and lists the indices, the matching keys or the most similar key.
std::size_t findKey(const std::vector<std::string>& keys, const std::string& query, const std::string& where);

}  // namespace scanmill
