// ZIP archives as PKWARE's APPNOTE.TXT 6.3 describes them (pkware.com/appnote): a header before each file's bytes
// (section 4.3.7), the same again in a directory behind all of them (4.3.12), and where that begins (4.3.16). Sizes and
// places from 4 GiB on, and numbers of files from 65535 on, stand in the wider fields of ZIP64 (4.3.14, 4.3.15, 4.5.3),
// only there, so that all other archives can be read by everybody. Files are deflated (RFC 1951) by zlib.

#include "exports/zip_file.h"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "exports/little_endian.h"

namespace scanmill {

namespace {

constexpr std::uint32_t kFull32 = 0xFFFFFFFF;  // in a narrow field: see the wide one
constexpr std::uint16_t kFull16 = 0xFFFF;
constexpr std::uint16_t kPlainVersion = 20;  // 2.0, the first with deflate
constexpr std::uint16_t kWideVersion = 45;   // 4.5, the first with ZIP64
constexpr std::uint16_t kUtf8Names = 1 << 11;
constexpr std::uint16_t kDate = 1 << 5 | 1;  // 1980-01-01: years since 1980, month, day
constexpr std::uint16_t kWideField = 1;      // the id of ZIP64's field

struct Entry {
  std::string_view name;
  std::uint16_t method = 0;  // 0: as it is, 8: deflated
  std::uint32_t crc = 0;
  std::uint64_t packed = 0;  // bytes
  std::uint64_t size = 0;    // bytes, unpacked
  std::uint64_t place = 0;   // of its header in the archive
};

std::uint32_t narrow(std::uint64_t value) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(value, kFull32));
}

// zlib takes and gives less than 4 GiB at a time.
std::string deflated(std::string_view bytes) {
  z_stream stream{};
  const int failure = deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  if (failure != Z_OK) throw Error(fmt::format("zlib cannot deflate: {}", zError(failure)));
  constexpr std::size_t kPiece = 1 << 20;
  const std::size_t room = std::min<std::size_t>(kPiece, deflateBound(&stream, static_cast<uLong>(bytes.size())));
  std::string packed;
  std::size_t taken = 0;
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    const std::size_t piece = std::min(kPiece, bytes.size() - taken);
    // zlib does not write to what it reads; its interface is older than const.
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + taken));
    stream.avail_in = static_cast<uInt>(piece);
    taken += piece;
    do {
      const std::size_t before = packed.size();
      packed.resize(before + room);
      stream.next_out = reinterpret_cast<Bytef*>(packed.data() + before);
      stream.avail_out = static_cast<uInt>(room);
      state = deflate(&stream, taken == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
      packed.resize(packed.size() - stream.avail_out);
    } while (stream.avail_out == 0 && state != Z_STREAM_END);
  }
  deflateEnd(&stream);
  return packed;
}

// What the two headers of a file have in common, from the version that is needed to the length of the name.
void putCommon(const Entry& entry, bool wide, std::string& bytes) {
  putNumber(wide ? kWideVersion : kPlainVersion, bytes);
  putNumber(kUtf8Names, bytes);
  putNumber(entry.method, bytes);
  putNumber(std::uint16_t{0}, bytes);  // midnight
  putNumber(kDate, bytes);
  putNumber(entry.crc, bytes);
}

void putHeader(const Entry& entry, std::string& bytes) {
  // Here ZIP64's field has both sizes or none.
  const bool wide = entry.packed >= kFull32 || entry.size >= kFull32;
  bytes += "PK\x03\x04";
  putCommon(entry, wide, bytes);
  putNumber(wide ? kFull32 : narrow(entry.packed), bytes);
  putNumber(wide ? kFull32 : narrow(entry.size), bytes);
  putNumber(static_cast<std::uint16_t>(entry.name.size()), bytes);
  putNumber(static_cast<std::uint16_t>(wide ? 20 : 0), bytes);
  bytes += entry.name;
  if (!wide) return;
  putNumber(kWideField, bytes);
  putNumber(std::uint16_t{16}, bytes);
  putNumber(entry.size, bytes);
  putNumber(entry.packed, bytes);
}

void putDirectoryEntry(const Entry& entry, std::string& bytes) {
  std::string wide;  // of the values that do not fit, in this order
  for (const std::uint64_t value : {entry.size, entry.packed, entry.place}) {
    if (value >= kFull32) putNumber(value, wide);
  }
  bytes += "PK\x01\x02";
  putNumber(wide.empty() ? kPlainVersion : kWideVersion, bytes);  // that it was made by
  putCommon(entry, !wide.empty(), bytes);
  putNumber(narrow(entry.packed), bytes);
  putNumber(narrow(entry.size), bytes);
  putNumber(static_cast<std::uint16_t>(entry.name.size()), bytes);
  putNumber(static_cast<std::uint16_t>(wide.empty() ? 0 : 4 + wide.size()), bytes);
  bytes.append(10, '\0');  // no comment, the first disk, no attributes
  putNumber(narrow(entry.place), bytes);
  bytes += entry.name;
  if (wide.empty()) return;
  putNumber(kWideField, bytes);
  putNumber(static_cast<std::uint16_t>(wide.size()), bytes);
  bytes += wide;
}

void putEnd(std::uint64_t files, std::uint64_t directory, std::string& bytes) {
  const std::uint64_t end = bytes.size();
  if (files >= kFull16 || directory >= kFull32 || end - directory >= kFull32) {
    bytes += "PK\x06\x06";
    putNumber(std::uint64_t{44}, bytes);  // bytes of this record from here on
    putNumber(kWideVersion, bytes);
    putNumber(kWideVersion, bytes);
    putNumber(std::uint64_t{0}, bytes);  // two numbers of disks
    for (const std::uint64_t value : {files, files, end - directory, directory}) putNumber(value, bytes);
    bytes += "PK\x06\x07";
    putNumber(std::uint32_t{0}, bytes);
    putNumber(end, bytes);
    putNumber(std::uint32_t{1}, bytes);  // of disks
  }
  bytes += "PK\x05\x06";
  putNumber(std::uint32_t{0}, bytes);  // two numbers of disks
  const auto number = static_cast<std::uint16_t>(std::min<std::uint64_t>(files, kFull16));
  putNumber(number, bytes);
  putNumber(number, bytes);
  putNumber(narrow(end - directory), bytes);
  putNumber(narrow(directory), bytes);
  putNumber(std::uint16_t{0}, bytes);  // no comment
}

}  // namespace

std::string zipOf(std::span<const std::pair<std::string, std::string>> files) {
  std::string bytes;
  std::vector<Entry> entries;
  for (const auto& [name, content] : files) {
    if (name.size() > kFull16)
      throw Error(fmt::format("a ZIP archive has no room for a name of {} bytes", name.size()));
    const std::string packed = deflated(content);
    const bool smaller = packed.size() < content.size();
    const std::string_view stored = smaller ? std::string_view(packed) : content;
    Entry entry{name, static_cast<std::uint16_t>(smaller ? 8 : 0), 0, stored.size(), content.size(), bytes.size()};
    entry.crc = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()));
    putHeader(entry, bytes);
    bytes += stored;
    entries.push_back(entry);
  }
  const std::uint64_t directory = bytes.size();
  for (const Entry& entry : entries) putDirectoryEntry(entry, bytes);
  putEnd(entries.size(), directory, bytes);
  return bytes;
}

}  // namespace scanmill
