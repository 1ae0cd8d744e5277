#pragma once

// Finds the offsets of a shard's members, so that a member can be read without reading the others.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace scanmill {

struct ShardMember {
  std::string name;
  std::uint64_t offset = 0;  // position of the member's first byte in the file
  std::uint64_t bytes = 0;
};

class ShardIndex {
 public:
  // Reads only the members' headers. If the end of the file is missing or damaged, the members before the damage can be
  // read. Throws the InputError of readTar() if the first member is damaged.
  explicit ShardIndex(std::filesystem::path file);
  ShardIndex(const ShardIndex&) = delete;
  ShardIndex& operator=(const ShardIndex&) = delete;

  const std::filesystem::path& file() const { return file_; }
  const std::vector<ShardMember>& members() const { return members_; }  // in the shard's order
  const ShardMember* find(std::string_view name) const;                 // the first member with that name; null: absent
  // Returns why members are missing, with the file's name; empty if the shard is complete.
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
