#pragma once

// Reads a tar file member by member.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

struct archive;

namespace scanmill {

// Reads the file from front to back, and skips the bytes of members that are not read. Throws an InputError with the
// file and the offset if the file is truncated, is not a tar file, or contains anything but regular files.
class TarReader {
 public:
  // `blockBytes`: number of bytes that are read from the disk at a time. It should be large if members are read, and
  // small if only headers are read.
  TarReader(const std::filesystem::path& file, std::size_t blockBytes);

  // Goes to the next member; returns false at the end of the archive.
  [[nodiscard]] bool next();

  // The following calls refer to the current member.
  const std::string& name() const { return name_; }
  std::uint64_t offset() const { return begin_; }  // position of the member's first byte in the file
  std::uint64_t bytes() const { return memberBytes_; }
  // Replaces `bytes` by the bytes of the member.
  void readInto(std::string& bytes);

 private:
  struct Free {
    void operator()(archive* tar) const;
  };

  std::uint64_t position() const;
  void checkEnd() const;
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path file_;
  std::unique_ptr<archive, Free> tar_;
  std::uint64_t size_ = 0;  // size of the file
  std::uint64_t begin_ = 0;
  std::uint64_t end_ = 0;  // end of the current member, with its padding
  std::uint64_t memberBytes_ = 0;
  std::string name_;
};

}  // namespace scanmill
