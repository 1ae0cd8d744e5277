#pragma once

// One tar shard while it is written.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace scanmill {

// POSIX ustar; a name too long for it gets a pax header. No clocks and no user names, so the same members give the same
// bytes. The file has its final name only after close(); without it (an exception, a killed run) it never gets one.
class ShardFile {
 public:
  explicit ShardFile(const std::filesystem::path& path);
  ~ShardFile();
  ShardFile(const ShardFile&) = delete;
  ShardFile& operator=(const ShardFile&) = delete;

  void add(const std::string& name, std::string_view bytes);

  struct Whole {
    std::string sha256;
    std::uint64_t bytes = 0;
  };
  Whole close();

  // What add() appends to the file, and what close() does.
  static std::uint64_t memberBytes(std::size_t nameLength, std::uint64_t bytes);
  static constexpr std::uint64_t kEndBytes = 1024;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
