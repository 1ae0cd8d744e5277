#pragma once

// What names of members and samples say.

#include <cstddef>
#include <string>
#include <vector>

namespace scanmill {

// "dir/key.top.ray_tracing.pcd": WebDataset's key ends at the first dot of the file's name. What a name lacks is empty.
struct MemberName {
  std::string key;
  std::string sensor;
  std::string method;
  std::string suffix;  // of the format
};
MemberName partsOfMember(const std::string& member);

// ASCII; members are named in lower case, whatever the sensor's name.
std::string lowerCase(std::string text);

// The key that is `wanted`, or that has this index from 0 ("12", "#12"), or the only one that holds it; empty: the
// middle one. Throws InputError with the nearest keys; `where` names what holds them.
std::size_t findKey(const std::vector<std::string>& keys, const std::string& wanted, const std::string& where);

}  // namespace scanmill
