// A file in NumPy's format NPY 1.0 has a magic number, the length of the header, the header (text of a Python
// dictionary) and the elements. The header is padded so that the elements begin at a multiple of 64 bytes.

#include "formats/npy.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cstdint>
#include <memory>

#include "base/error.h"
#include "base/input_budget.h"
#include "base/text_scan.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

constexpr std::size_t kAlignment = 64;     // the elements begin at a multiple of this (bytes)
constexpr std::size_t kBeforeHeader = 10;  // bytes: magic number, version and length of the header

// Returns the size (bytes) of an element of a NumPy type: the number at the end ("<f4"), times four for text ("<U12").
std::size_t elementSize(std::string_view descr) {
  std::size_t size = 0;
  const char* const end = descr.data() + descr.size();
  const bool parsed = descr.size() > 2 && std::from_chars(descr.data() + 2, end, size).ptr == end;
  if (!parsed) throw Error("'{}' is no type of NumPy with a size", descr);
  return descr[1] == 'U' ? 4 * size : size;
}

// A callback for the output of libarchive: appends `piece` to the string `bytes`. Returns the number of bytes.
la_ssize_t append(archive*, void* bytes, const void* piece, std::size_t size) {
  static_cast<std::string*>(bytes)->append(static_cast<const char*>(piece), size);
  return static_cast<la_ssize_t>(size);
}

constexpr std::size_t kMostBytes = std::size_t{4} << 30;  // largest size of an array (bytes)

// Returns the text that follows `key` in the header, which is a Python dictionary; empty if the key is absent.
std::string_view valueIn(std::string_view header, std::string_view key) {
  const std::string quoted = fmt::format("'{}': ", key);
  const std::size_t at = header.find(quoted);
  return at == std::string_view::npos ? std::string_view() : header.substr(at + quoted.size());
}

// Returns the array of a .npy file with this name and these bytes. `what`: name of the archive in messages.
NpyArray parseNpy(const std::string& name, const std::string& file, const std::string& what) {
  const auto fail = [&](const std::string& reason) { throw InputError({what + ": " + name}, reason); };
  if (file.size() < kBeforeHeader || !file.starts_with("\x93NUMPY\1")) fail("is no array in NumPy's format 1.0");
  const auto byte = [&](std::size_t at) { return static_cast<std::size_t>(static_cast<unsigned char>(file[at])); };
  const std::size_t headerBytes = byte(8) | byte(9) << 8;
  if (kBeforeHeader + headerBytes > file.size()) fail("ends within its header");
  const std::string_view header = std::string_view(file).substr(kBeforeHeader, headerBytes);
  NpyArray array;
  array.name = name.substr(0, name.size() - std::string_view(".npy").size());
  const std::string_view type = valueIn(header, "descr");
  if (type.size() > 4) array.type = type.substr(1, 3);
  if (!valueIn(header, "fortran_order").starts_with("False")) fail("is in Fortran's order: save it in C's");
  const std::string_view shape = valueIn(header, "shape");
  std::vector<std::string_view> sizes;
  splitCells(shape.substr(0, shape.find(')')), ',', sizes);
  if (!sizes[0].starts_with('(')) fail("its header states no shape");
  sizes[0].remove_prefix(1);
  for (const std::string_view size : sizes) {  // "(3,)" has an empty cell
    if (!size.empty() && !parseNumber(size, array.shape.emplace_back())) fail("its header states no shape");
  }
  array.bytes = file.substr(kBeforeHeader + headerBytes);
  const bool isNumber = array.type.size() == 3 &&
                        std::string_view("fui").find(array.type[1]) != std::string_view::npos && array.type[2] >= '1' &&
                        array.type[2] <= '8';
  if (!isNumber) return array;  // callers that need numbers refuse it
  std::size_t expectedBytes = elementSize(array.type);
  if (expectedBytes > 1 && array.type[0] != '<') {
    fail(fmt::format("is of the type {}, big-endian: save it as <f4", array.type));
  }
  for (const std::size_t size : array.shape) {
    if (size != 0 && expectedBytes > kMostBytes / size) fail("states a shape of more than 4 GiB");
    expectedBytes *= size;
  }
  if (array.bytes.size() != expectedBytes) {
    fail(fmt::format("has {} bytes where its shape ({}) of {} has {}", array.bytes.size(), fmt::join(array.shape, ", "),
                     array.type, expectedBytes));
  }
  return array;
}

}  // namespace

std::string npyOf(std::string_view descr, const std::vector<std::size_t>& shape, std::string_view bytes) {
  std::size_t expectedBytes = elementSize(descr);
  std::string dimensions;
  for (const std::size_t length : shape) {
    expectedBytes *= length;
    dimensions += fmt::format("{}, ", length);
  }
  if (bytes.size() != expectedBytes) {
    throw Error("{} bytes for an array {} of shape ({}), which has {}", bytes.size(), descr, dimensions, expectedBytes);
  }
  // Python writes "(3,)" for one dimension, "(3, 4)" for more.
  if (!dimensions.empty()) dimensions.resize(dimensions.size() - (shape.size() == 1 ? 1 : 2));
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", descr, dimensions);
  const std::size_t unpaddedBytes = kBeforeHeader + header.size() + 1;  // with the line feed
  header.append((kAlignment - unpaddedBytes % kAlignment) % kAlignment, ' ');
  header += '\n';
  if (header.size() > 65535) throw Error("an array of {} dimensions has no NPY 1.0", shape.size());
  std::string file("\x93NUMPY\x01\x00", 8);
  putNumber(static_cast<std::uint16_t>(header.size()), file);
  file += header;
  file += bytes;
  return file;
}

std::string zipOf(std::span<const std::pair<std::string, std::string>> files) {
  std::string bytes;
  const std::unique_ptr<archive, decltype(&archive_write_free)> zip(archive_write_new(), &archive_write_free);
  const auto require = [&](la_ssize_t result) {
    if (result < ARCHIVE_OK) throw Error("a ZIP archive cannot be made: {}", archive_error_string(zip.get()));
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

std::vector<NpyArray> readNpzArrays(std::string_view bytes, const std::string& what) {
  std::vector<NpyArray> arrays;
  const std::unique_ptr<archive, decltype(&archive_read_free)> zip(archive_read_new(), &archive_read_free);
  const auto fail = [&] {
    const char* const text = archive_error_string(zip.get());
    throw InputError({what}, "is no sound archive .npz: {}", text != nullptr ? text : "unknown");
  };
  archive_read_support_format_zip(zip.get());
  if (archive_read_open_memory(zip.get(), bytes.data(), bytes.size()) != ARCHIVE_OK) fail();
  archive_entry* entry = nullptr;
  for (;;) {
    const int result = archive_read_next_header(zip.get(), &entry);
    if (result == ARCHIVE_EOF) return arrays;
    if (result != ARCHIVE_OK) fail();
    const char* const path = archive_entry_pathname(entry);
    const std::string name = path != nullptr ? path : "";
    if (!name.ends_with(".npy")) continue;
    std::string content;
    std::string piece(std::size_t{1} << 16, '\0');
    la_ssize_t read = 0;
    while ((read = archive_read_data(zip.get(), piece.data(), piece.size())) > 0) {
      chargeBytes(static_cast<double>(read), {what});
      content.append(piece, 0, static_cast<std::size_t>(read));
    }
    if (read < 0) fail();
    arrays.push_back(parseNpy(name, content, what));
  }
}

}  // namespace scanmill
