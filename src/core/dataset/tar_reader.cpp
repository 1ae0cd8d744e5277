#include "dataset/tar_reader.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/core.h>

#include <system_error>

#include "base/error.h"
#include "dataset/reader.h"
#include "formats/format.h"

namespace scanmill {

namespace {

constexpr std::uint64_t kTarBlock = 512;
constexpr std::uint64_t kEndBytes = 2 * kTarBlock;
constexpr std::size_t kMostNameBytes = 4096;  // largest name of a member (bytes), the usual limit of paths

}  // namespace

TarReader::TarReader(const std::filesystem::path& file, std::size_t blockBytes)
    : file_(file), tar_(archive_read_new()) {
  std::error_code failure;
  size_ = std::filesystem::file_size(file_, failure);
  if (failure) throw InputError({file_.string()}, "cannot be read: " + failure.message());
  archive_read_support_format_tar(tar_.get());
  if (archive_read_open_filename(tar_.get(), file_.c_str(), blockBytes) != ARCHIVE_OK) fail("cannot be read as tar");
}

bool TarReader::next() {
  archive_entry* entry = nullptr;
  const int result = archive_read_next_header(tar_.get(), &entry);
  if (result == ARCHIVE_EOF) {
    checkEnd();
    return false;
  }
  if (result < ARCHIVE_WARN) fail("is not a complete tar file");
  const char* name = archive_entry_pathname(entry);
  if (name == nullptr) fail("has a member whose name cannot be read");
  name_ = name;
  if (name_.size() > kMostNameBytes) {
    fail(fmt::format("has a member whose name has {} bytes, but at most {} can be read", name_.size(), kMostNameBytes));
  }
  if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_sparse_count(entry) > 0) {
    fail(fmt::format("has a member '{}' that is not a plain file", name_));
  }
  begin_ = position();
  memberBytes_ = static_cast<std::uint64_t>(archive_entry_size(entry));
  if (memberBytes_ > size_ - begin_) {
    fail(fmt::format("is truncated: member '{}' has {} bytes and the file ends after {}", name_, memberBytes_,
                     size_ - begin_));
  }
  end_ = begin_ + (memberBytes_ + kTarBlock - 1) / kTarBlock * kTarBlock;
  return true;
}

void TarReader::readInto(std::string& bytes) {
  bytes.resize(memberBytes_);
  const la_ssize_t got = archive_read_data(tar_.get(), bytes.data(), bytes.size());
  if (got < 0 || static_cast<std::uint64_t>(got) != memberBytes_) fail(fmt::format("is truncated in '{}'", name_));
}

void TarReader::Free::operator()(archive* tar) const {
  archive_read_free(tar);
}

std::uint64_t TarReader::position() const {
  return static_cast<std::uint64_t>(archive_filter_bytes(tar_.get(), 0));
}

// Throws InputError if the end mark is missing. Libarchive accepts a file that ends between two members; only the end
// mark shows that the file is complete.
void TarReader::checkEnd() const {
  if (size_ >= end_ + kEndBytes) return;
  throw InputError({file_.string()},
                   fmt::format("is truncated: no end mark at offset {} (the file has {} bytes)", end_, size_));
}

void TarReader::fail(const std::string& what) const {
  const char* reason = archive_error_string(tar_.get());
  throw InputError({file_.string()},
                   fmt::format("{} at offset {}{}{}", what, position(), reason ? ": " : "", reason ? reason : ""));
}

namespace {

constexpr std::size_t kBlockBytes = 1 << 20;  // bytes to read at a time

}  // namespace

void readTar(const std::filesystem::path& file,
             const std::function<void(const std::string&, std::string_view)>& visit) {
  TarReader tar(file, kBlockBytes);
  std::string bytes;
  while (tar.next()) {
    tar.readInto(bytes);
    visit(tar.name(), bytes);
  }
}

Scan decodeMember(const std::string& name, std::string_view bytes) {
  const std::size_t dot = name.rfind('.');
  const std::string suffix = dot == std::string::npos ? std::string() : name.substr(dot + 1);
  const FormatEntry* entry = formatBySuffix(suffix);
  if (entry == nullptr) {
    std::string known;
    for (const FormatEntry& format : formats()) known += fmt::format("{}.{}", known.empty() ? "" : ", ", format.suffix);
    throw InputError({name}, fmt::format("no format reads '.{}' (known: {})", suffix, known));
  }
  Value none;
  none.kind = Value::Kind::Map;
  Fields options(none, "format");
  return entry->make(options)->decode(bytes, name);
}

}  // namespace scanmill
