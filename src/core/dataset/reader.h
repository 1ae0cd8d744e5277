#pragma once

// Reads the shards of a dataset, which are tar files.
//
//   readTar("out/quickstart/train/train-000000.tar", [](const std::string& name, std::string_view bytes) {
//     if (name.ends_with(".drc")) std::printf("%s: %zu points\n", name.c_str(), decodeMember(name, bytes).size());
//   });

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

// Calls visit(name, bytes) for each member of a tar file, in the file's order. Throws an InputError with the file and
// the offset if the file is truncated or not a tar file.
void readTar(const std::filesystem::path& file, const std::function<void(const std::string&, std::string_view)>& visit);

// Decodes a member of a shard. The suffix of `name` determines the format. Throws an InputError that names the member
// if no format has this suffix, or if the bytes cannot be decoded.
Scan decodeMember(const std::string& name, std::string_view bytes);

struct ShardMember {
  std::string name;
  std::uint64_t offset = 0;  // position of the member's first byte in the file
  std::uint64_t bytes = 0;
};

// Finds the offsets of a shard's members, so that a member can be read without reading the others.
class ShardIndex {
 public:
  // Reads only the members' headers. If the end of the file is missing or damaged, the members before the damage can be
  // read. Throws the InputError of readTar() if the first member is damaged.
  explicit ShardIndex(std::filesystem::path file);
  ShardIndex& operator=(ShardIndex&&) = delete;  // neither copied nor moved

  const std::filesystem::path& file() const { return file_; }
  const std::vector<ShardMember>& members() const { return members_; }  // in the shard's order
  const ShardMember* find(std::string_view name) const;                 // the first member with that name; null: absent
  // Returns a message that names the file and says why members are missing; empty if the shard is complete.
  const std::string& damage() const { return damage_; }

  // Returns a member's bytes. May be called from any thread. Throws an InputError if the file was removed or truncated
  // after the headers were read.
  std::string read(const ShardMember& member) const;

 private:
  std::filesystem::path file_;
  std::vector<ShardMember> members_;
  std::string damage_;
  std::unordered_map<std::string_view, std::size_t> byName_;  // index in members_, by name; keys are views of members_
};

}  // namespace scanmill
