#pragma once

// Where the members of a shard lie, so that one can be read without the others.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace scanmill {

struct ShardMember {
  std::string name;
  std::uint64_t offset = 0;  // of its first byte in the file
  std::uint64_t bytes = 0;
};

// What becomes of a shard whose end is missing or damaged.
enum class DamagedShard {
  Refused,
  ReadAsFarAsWhole,  // its members up to there; refused where there is none
};

class ShardIndex {
 public:
  // Reads the headers alone. Throws InputError for what readTar() refuses, with the same message.
  explicit ShardIndex(std::filesystem::path file, DamagedShard damaged = DamagedShard::Refused);
  ShardIndex(const ShardIndex&) = delete;
  ShardIndex& operator=(const ShardIndex&) = delete;

  const std::filesystem::path& file() const { return file_; }
  const std::vector<ShardMember>& members() const { return members_; }  // in the shard's order
  const ShardMember* find(std::string_view name) const;                 // the first of that name; null where absent
  // Why the members are not all that there were, with the file's name; empty: the shard is whole.
  const std::string& damage() const { return damage_; }

  // From any thread. Throws InputError where the file has been removed or cut short since.
  std::string read(const ShardMember& member) const;

 private:
  std::filesystem::path file_;
  std::vector<ShardMember> members_;
  std::string damage_;
  std::unordered_map<std::string_view, std::size_t> byName_;  // views of members_
};

}  // namespace scanmill
