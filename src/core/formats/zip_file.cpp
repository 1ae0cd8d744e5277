#include "formats/zip_file.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/core.h>

#include <memory>

#include "base/error.h"

namespace scanmill {

namespace {

la_ssize_t append(archive*, void* bytes, const void* piece, std::size_t size) {
  static_cast<std::string*>(bytes)->append(static_cast<const char*>(piece), size);
  return static_cast<la_ssize_t>(size);
}

}  // namespace

std::string zipOf(std::span<const std::pair<std::string, std::string>> files) {
  std::string bytes;
  const std::unique_ptr<archive, decltype(&archive_write_free)> zip(archive_write_new(), &archive_write_free);
  const auto require = [&](la_ssize_t result) {
    if (result < ARCHIVE_OK)
      throw Error(fmt::format("a ZIP archive cannot be made: {}", archive_error_string(zip.get())));
  };
  require(archive_write_set_format_zip(zip.get()));
  require(archive_write_set_bytes_per_block(zip.get(), 0));
  require(archive_write_open(zip.get(), &bytes, nullptr, append, nullptr));
  for (const auto& [name, content] : files) {
    const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(), &archive_entry_free);
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(content.size()));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_mtime(entry.get(), 0, 0);  // stored as 1980, the earliest time of ZIP
    require(archive_write_header(zip.get(), entry.get()));
    require(archive_write_data(zip.get(), content.data(), content.size()));
  }
  require(archive_write_close(zip.get()));
  return bytes;
}

}  // namespace scanmill
