#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "dataset/reader.h"
#include "formats/format.h"

namespace scanmill {

namespace {

constexpr std::uint64_t kTarBlock = 512;
constexpr std::uint64_t kEndBytes = 2 * kTarBlock;
constexpr std::size_t kMostNameBytes = 4096;  // largest name of a member (bytes), the usual limit of paths
// Number of bytes to read at a time: kBlockBytes if members are read, kHeaderBytes if only headers are read.
constexpr std::size_t kBlockBytes = 1 << 20;
constexpr std::size_t kHeaderBytes = 2048;

// Reads a tar file from front to back, and skips the bytes of members that are not read. Throws an InputError with the
// file and the offset if the file is truncated, is not a tar file, or contains anything but regular files.
class TarReader {
 public:
  // `blockBytes`: number of bytes that are read from the disk at a time. It should be large if members are read, and
  // small if only headers are read.
  TarReader(const std::filesystem::path& file, std::size_t blockBytes) : file_(file), tar_(archive_read_new()) {
    std::error_code failure;
    size_ = std::filesystem::file_size(file_, failure);
    if (failure) throw InputError({file_.string()}, "cannot be read: " + failure.message());
    archive_read_support_format_tar(tar_.get());
    if (archive_read_open_filename(tar_.get(), file_.c_str(), blockBytes) != ARCHIVE_OK) fail("cannot be read as tar");
  }

  // Goes to the next member; returns false at the end of the archive.
  [[nodiscard]] bool next() {
    archive_entry* entry = nullptr;
    const int result = archive_read_next_header(tar_.get(), &entry);
    if (result == ARCHIVE_EOF) {
      // Libarchive accepts a file that ends between two members; only the end mark shows that the file is complete.
      if (size_ >= memberEnd_ + kEndBytes) return false;
      throw InputError({file_.string()}, "is truncated: no end mark at offset {} (the file has {} bytes)", memberEnd_,
                       size_);
    }
    if (result < ARCHIVE_WARN) fail("is not a complete tar file");
    const char* name = archive_entry_pathname(entry);
    if (name == nullptr) fail("has a member whose name cannot be read");
    member_ = {name, position(), static_cast<std::uint64_t>(archive_entry_size(entry))};
    if (member_.name.size() > kMostNameBytes) {
      fail(fmt::format("has a member whose name has {} bytes, but at most {} can be read", member_.name.size(),
                       kMostNameBytes));
    }
    if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_sparse_count(entry) > 0) {
      fail(fmt::format("has a member '{}' that is not a plain file", member_.name));
    }
    if (member_.bytes > size_ - member_.offset) {
      fail(fmt::format("is truncated: member '{}' has {} bytes and the file ends after {}", member_.name, member_.bytes,
                       size_ - member_.offset));
    }
    memberEnd_ = member_.offset + (member_.bytes + kTarBlock - 1) / kTarBlock * kTarBlock;
    return true;
  }

  // Returns the member that next() has gone to.
  const ShardMember& member() const { return member_; }
  // Replaces `bytes` by the bytes of the member.
  void readInto(std::string& bytes) {
    bytes.resize(member_.bytes);
    const la_ssize_t readBytes = archive_read_data(tar_.get(), bytes.data(), bytes.size());
    if (readBytes < 0 || static_cast<std::uint64_t>(readBytes) != member_.bytes)
      fail(fmt::format("is truncated in '{}'", member_.name));
  }

 private:
  struct Free {
    void operator()(archive* tar) const { archive_read_free(tar); }
  };

  std::uint64_t position() const { return static_cast<std::uint64_t>(archive_filter_bytes(tar_.get(), 0)); }

  [[noreturn]] void fail(const std::string& what) const {
    const char* reason = archive_error_string(tar_.get());
    throw InputError({file_.string()}, "{} at offset {}{}{}", what, position(), reason ? ": " : "",
                     reason ? reason : "");
  }

  std::filesystem::path file_;
  std::unique_ptr<archive, Free> tar_;
  std::uint64_t size_ = 0;       // size of the file
  ShardMember member_;           // the current member
  std::uint64_t memberEnd_ = 0;  // offset of the end of its padding
};

std::string errnoText(int error) {
  return std::generic_category().message(error);
}

}  // namespace

void readTar(const std::filesystem::path& file,
             const std::function<void(const std::string&, std::string_view)>& visit) {
  TarReader tar(file, kBlockBytes);
  std::string bytes;
  while (tar.next()) {
    tar.readInto(bytes);
    visit(tar.member().name, bytes);
  }
}

Scan decodeMember(const std::string& name, std::string_view bytes) {
  const std::size_t dot = name.rfind('.');
  const std::string suffix = dot == std::string::npos ? std::string() : name.substr(dot + 1);
  const FormatEntry* entry = formatBySuffix(suffix);
  if (entry == nullptr) {
    std::vector<std::string_view> suffixes;
    suffixes.reserve(formats().size());
    for (const FormatEntry& known : formats()) suffixes.push_back(known.suffix);
    throw InputError({name}, "no format reads '.{}' (known: .{})", suffix, fmt::join(suffixes, ", ."));
  }
  const Value noOptions = mapValue();
  Fields options(noOptions, "format");
  return entry->make(options)->decode(bytes, name);
}

ShardIndex::ShardIndex(std::filesystem::path file) : file_(std::move(file)) {
  TarReader tar(file_, kHeaderBytes);
  try {
    while (tar.next()) members_.push_back(tar.member());
  } catch (const InputError& e) {
    if (members_.empty()) throw;
    damage_ = e.what();
  }
  byName_.reserve(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) byName_.emplace(members_[i].name, i);
}

const ShardMember* ShardIndex::find(std::string_view name) const {
  const auto found = byName_.find(name);
  return found == byName_.end() ? nullptr : &members_[found->second];
}

std::string ShardIndex::read(const ShardMember& member) const {
  const Descriptor file(::open(file_.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number < 0) throw InputError({file_.string()}, "cannot be read: " + errnoText(errno));
  std::string bytes(member.bytes, '\0');
  std::size_t done = 0;  // bytes read so far: pread() may read fewer than it is asked for
  while (done < bytes.size()) {
    const ssize_t count =
        ::pread(file.number, bytes.data() + done, bytes.size() - done, static_cast<off_t>(member.offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw InputError({file_.string()}, "cannot read '{}': {}", member.name, errnoText(errno));
    if (count == 0) {
      throw InputError({file_.string()}, "is truncated in '{}': it was longer when it was opened", member.name);
    }
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

}  // namespace scanmill
