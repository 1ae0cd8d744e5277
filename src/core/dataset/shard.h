#pragma once

// Writes one shard, a tar file.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace scanmill {

// A tar file in the format POSIX ustar; a name that is too long for ustar gets a pax header. The file contains no times
// and no user names, so that the same members give the same bytes. Only close() gives the file its final name, so that
// a file is never incomplete under that name. All calls throw an Error with the path if the disk fails.
class ShardFile {
 public:
  // Follows no links below `folder` (base/own_folder.h); `path` begins with `folder`.
  ShardFile(const std::filesystem::path& folder, const std::filesystem::path& path);
  ~ShardFile();
  ShardFile(const ShardFile&) = delete;
  ShardFile& operator=(const ShardFile&) = delete;

  // Appends a member.
  void add(const std::string& name, std::string_view bytes);

  struct Whole {
    std::string sha256;
    std::uint64_t bytes = 0;
  };
  // Completes the file and gives it its final name. Returns the file's hash and size.
  Whole close();

  // Returns the number of bytes that add() appends to the file for a member; close() appends kEndBytes.
  static std::uint64_t memberBytes(std::size_t nameLength, std::uint64_t bytes);
  static constexpr std::uint64_t kEndBytes = 1024;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
