#pragma once

// Writes one shard, a tar file.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace scanmill {

// A file in the format POSIX ustar; a name that is too long for that gets a pax header. It holds no times and no user
// names, so that the same members give the same bytes. The file gets its final name by close(); without that, be it for
// an exception or a killed run, it never has it. All calls throw an Error with the path where the disk fails.
class ShardFile {
 public:
  explicit ShardFile(const std::filesystem::path& path);
  ~ShardFile();
  ShardFile(const ShardFile&) = delete;
  ShardFile& operator=(const ShardFile&) = delete;

  // Appends a member.
  void add(const std::string& name, std::string_view bytes);

  struct Whole {
    std::string sha256;
    std::uint64_t bytes = 0;
  };
  // Ends the file and gives it its final name. Returns its hash and size.
  Whole close();

  // How many bytes add() appends to the file for a member, and how many close() does.
  static std::uint64_t memberBytes(std::size_t nameLength, std::uint64_t bytes);
  static constexpr std::uint64_t kEndBytes = 1024;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
