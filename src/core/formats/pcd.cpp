// pcd: PCD 0.7, the Point Cloud Library's own format, lossless.
//
//   format: pcd
//   encoding: binary_compressed   # columns compressed by LZF; or binary: uncompressed rows; or ascii
//
// Fields: x, y and z as float32, then the scan's columns in the types of the table of columns (scan/columns.h), except
// the label, which is uint32 as in PCL's PointXYZL. An organised scan keeps WIDTH and HEIGHT, and its misses are NaN. A
// comment in the header states the sensor's rings and columns.

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "base/raw_vector.h"
#include "formats/little_endian.h"
#include "formats/lzf.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

enum class Encoding { Compressed, Binary, Ascii };
const std::vector<std::string> kEncodingNames{"binary_compressed", "binary", "ascii"};  // in the order of Encoding

constexpr double kMostLzfGrowth = 33.0 / 32;  // LZF adds one byte to every 32 bytes that it cannot shrink

template <class T>
constexpr std::size_t storedSize(std::string_view name) {
  return name == kLabel.row.name ? sizeof(std::uint32_t) : sizeof(T);
}

// Returns the size of a point (bytes) in a scan with these columns.
std::size_t rowSize(ColumnSet columns) {
  std::size_t size = sizeof(Vec3f);
  forEachColumn(
      [&]<class Key>(Key key) { size += columns.has(key) ? storedSize<typename Key::Value>(key.row.name) : 0; });
  return size;
}

std::size_t rowSize(const Scan& scan) {
  std::size_t size = sizeof(Vec3f);
  visitColumns(scan, [&]<class T>(std::string_view name, const std::vector<T>&) { size += storedSize<T>(name); });
  return size;
}

double mostHeaderBytes(ColumnSet columns) {
  std::size_t bytes = 350;  // upper bound for the header without columns
  for (const std::string& name : columns.names()) bytes += name.size() + std::string_view(" , 4 F 1").size();
  return static_cast<double>(bytes);
}

template <class T>
constexpr char kPcdType = std::is_floating_point_v<T> ? 'F'
                          : std::is_signed_v<T>       ? 'I'
                                                      : 'U';

// Returns the header of a file. `data`: the encoding as the header names it.
std::string header(const Scan& scan, std::string_view data) {
  std::string fields = "x y z";
  std::string sizes = "4 4 4";
  std::string types = "F F F";
  std::string counts = "1 1 1";
  visitColumns(scan, [&]<class T>(std::string_view name, const std::vector<T>&) {
    fields += fmt::format(" {}", name);
    sizes += fmt::format(" {}", storedSize<T>(name));
    types += fmt::format(" {}", kPcdType<T>);
    counts += " 1";
  });
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\n{} {} {} {}\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n"
      "WIDTH {}\nHEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA {}\n",
      kPcdSensorComment, scan.rings, scan.columns, scan.organised ? "organised" : "dense", fields, sizes, types, counts,
      scan.width(), scan.height(), scan.size(), data);
}

// Writes values `stride` bytes apart, the first one at `to`.
template <class T>
void scatter(const T* values, std::size_t count, char* to, std::size_t stride) {
  if (stride == sizeof(T)) {
    std::memcpy(to, values, sizeof(T) * count);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) std::memcpy(to + i * stride, values + i, sizeof(T));
}

// Writes a column of the scan into rows `stride` bytes apart. A label has 32 bits in files and 16 bits in scans.
template <class T>
void scatterColumn(std::string_view name, const T* values, std::size_t count, char* to, std::size_t stride) {
  if constexpr (std::is_same_v<T, decltype(kLabel)::Value>) {
    if (name == kLabel.row.name) {
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t stored = values[i];
        std::memcpy(to + i * stride, &stored, sizeof(stored));
      }
      return;
    }
  }
  scatter(values, count, to, stride);
}

// Appends the points as rows, block by block. A block fits into the first-level cache and is filled column by column.
void appendBinary(const Scan& scan, std::string& out) {
  constexpr std::size_t kBlockBytes = 12 * 1024;
  const std::size_t stride = rowSize(scan);
  const std::size_t rows = kBlockBytes / stride;
  if (rows == 0) throw Error("a row of {} bytes is wider than binary PCDs of {} hold", stride, kBlockBytes);
  out.reserve(out.size() + stride * scan.size());
  char block[kBlockBytes];
  for (std::size_t first = 0; first < scan.size(); first += rows) {
    const std::size_t count = std::min(rows, scan.size() - first);
    scatter(scan.position.data() + first, count, block, stride);
    char* to = block + sizeof(Vec3f);
    visitColumns(scan, [&]<class T>(std::string_view name, const std::vector<T>& values) {
      scatterColumn(name, values.data() + first, count, to, stride);
      to += storedSize<T>(name);
    });
    out.append(block, stride * count);
  }
}

// Appends the sizes after and before compression, then the columns in succession, compressed together by LZF.
void appendCompressed(const Scan& scan, std::string& out) {
  const std::size_t points = scan.size();
  const std::size_t bytes = rowSize(scan) * points;
  const std::size_t mostPackedBytes = mostLzfBytes(bytes);
  if (mostPackedBytes > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("{} points are more than a compressed PCD holds: use encoding binary", points);
  }
  thread_local RawVector<char> columns, packed;
  columns.resize(bytes);
  packed.resize(mostPackedBytes);
  char* to = columns.data();
  for (const auto axis : {&Vec3f::x, &Vec3f::y, &Vec3f::z}) {
    for (std::size_t i = 0; i < points; ++i) {
      std::memcpy(to + i * sizeof(float), &(scan.position[i].*axis), sizeof(float));
    }
    to += sizeof(float) * points;
  }
  visitColumns(scan, [&]<class T>(std::string_view name, const std::vector<T>& values) {
    scatterColumn(name, values.data(), points, to, storedSize<T>(name));
    to += storedSize<T>(name) * points;
  });
  const std::size_t packedBytes = compressLzf(columns.data(), bytes, packed.data());
  out.reserve(out.size() + 2 * sizeof(std::uint32_t) + packedBytes);
  putNumber(static_cast<std::uint32_t>(packedBytes), out);
  putNumber(static_cast<std::uint32_t>(bytes), out);
  out.append(packed.data(), packedBytes);
}

class Pcd : public Format {
 public:
  explicit Pcd(Encoding encoding) : encoding_(encoding) {}

  double mostBytes(const ScanOutline& outline) const override {
    const auto points = static_cast<double>(outline.points);
    if (encoding_ == Encoding::Ascii) {
      return mostHeaderBytes(outline.held) + points * static_cast<double>(longestRow(outline.held));
    }
    const double raw = points * static_cast<double>(rowSize(outline.held));
    return mostHeaderBytes(outline.held) + (encoding_ == Encoding::Binary ? raw : raw * kMostLzfGrowth);
  }

  std::string encode(const Scan& scan) const override {
    requireConsistent(scan);
    // LZF cannot encode an empty block: a scan without points is written without compression.
    const Encoding used = encoding_ == Encoding::Compressed && scan.size() == 0 ? Encoding::Binary : encoding_;
    std::string out = header(scan, kEncodingNames[static_cast<std::size_t>(used)]);
    if (used == Encoding::Ascii) appendRows(scan, ' ', out);
    if (used == Encoding::Binary) appendBinary(scan, out);
    if (used == Encoding::Compressed) appendCompressed(scan, out);
    return out;
  }

  Scan decode(std::string_view bytes, const std::string& what) const override {
    return scanOf(readPcd(bytes, what, false), what);
  }

 private:
  Encoding encoding_;
};

}  // namespace

std::unique_ptr<Format> makePcd(Fields& options) {
  const std::string name = options.choice("encoding", kEncodingNames, "binary_compressed");
  options.finish();
  return std::make_unique<Pcd>(static_cast<Encoding>(std::ranges::find(kEncodingNames, name) - kEncodingNames.begin()));
}

}  // namespace scanmill
