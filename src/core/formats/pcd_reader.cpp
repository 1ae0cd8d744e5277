#include <fmt/format.h>
#include <fmt/ranges.h>
#include <lzf.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "base/error.h"
#include "base/text_scan.h"
#include "formats/little_endian.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

using Words = std::vector<std::string_view>;

struct PcdField {
  std::string_view name;
  std::uint64_t size = 0;    // bytes per element
  char type = 0;             // 'F' (float), 'U' (unsigned) or 'I' (signed)
  std::uint64_t count = 1;   // elements per point
  std::uint64_t offset = 0;  // bytes from the start of a row
};

struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint64_t width = 0;
  std::uint64_t height = 1;
  std::uint64_t points = 0;
  std::uint64_t rowBytes = 0;                          // bytes per point
  std::string_view data;                               // how the points are encoded: the word behind DATA
  std::string_view body;                               // bytes behind the header
  int bodyLine = 0;                                    // line where the body starts
  std::optional<std::array<std::uint64_t, 2>> sensor;  // rings and columns, if a comment states them
  bool organised = false;
  Pose worldFromFile;

  void setOffsets() {
    rowBytes = 0;
    for (PcdField& field : fields) {
      field.offset = rowBytes;
      rowBytes += field.size * field.count;
    }
  }
};

constexpr std::uint64_t kMostFields = 1024;
constexpr std::uint64_t kMostElements = 65536;
// Largest factor by which LZF data grow when decompressed: 3 bytes, the longest back reference, become 264.
constexpr std::uint64_t kLzfGain = 88;

std::uint64_t readCount(std::string_view word, std::string_view key, std::uint64_t most, const Location& where) {
  std::uint64_t value = 0;
  if (!parseNumber(word, value) || value > most) {
    throw InputError(where, "{} must be an integer of 0 to {}, not '{}'", key, most, word.substr(0, 40));
  }
  return value;
}

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& what) : rest_(bytes), where_{what, 0, 0} {}

  PcdHeader read() {
    while (header_.data.empty()) {
      ++where_.line;
      if (rest_.empty()) throw InputError(where_, "not a PCD file, or its header is truncated");
      const std::string_view line = takeLine(rest_);
      line.starts_with('#') ? readComment(line) : readLine(wordsOf(line));
    }
    header_.body = rest_;
    header_.bodyLine = where_.line + 1;
    check();
    return std::move(header_);
  }

 private:
  void readComment(std::string_view line) {
    if (!line.starts_with(kPcdSensorComment)) return;
    const Words words = wordsOf(line.substr(kPcdSensorComment.size()));
    if (words.size() != 3) throw InputError(where_, "the sensor comment must hold rings, columns and a word");
    header_.sensor = {readCount(words[0], "rings", UINT32_MAX, where_),
                      readCount(words[1], "columns", UINT32_MAX, where_)};
    header_.organised = words[2] == "organised";
  }

  // Reads a line of the header, which begins with its key, into header_ and points_.
  void readLine(const Words& words) {
    if (words.empty()) return;
    const std::string_view key = words[0];
    if (key == "VERSION") return;
    if (key == "VIEWPOINT") return readViewpoint(words);
    if (key == "FIELDS" || key == "COLUMNS") {
      if (words.size() - 1 > kMostFields) throw InputError(where_, "more than {} fields", kMostFields);
      header_.fields.resize(words.size() - 1);
      return perField(words, [&](PcdField& field, std::string_view word) { field.name = word; });
    }
    const auto count = [&](std::string_view word, std::uint64_t most) { return readCount(word, key, most, where_); };
    if (key == "SIZE") return perField(words, [&](PcdField& field, auto word) { field.size = count(word, 8); });
    if (key == "TYPE") return perField(words, [&](PcdField& field, auto word) { field.type = word[0]; });
    if (key == "COUNT") {
      return perField(words, [&](PcdField& field, auto word) { field.count = count(word, kMostElements); });
    }
    if (words.size() == 2 && key == "WIDTH") {
      header_.width = count(words[1], UINT32_MAX);
    } else if (words.size() == 2 && key == "HEIGHT") {
      header_.height = count(words[1], UINT32_MAX);
    } else if (words.size() == 2 && key == "POINTS") {
      points_ = count(words[1], UINT32_MAX);
    } else if (words.size() == 2 && key == "DATA") {
      header_.data = words[1];
    } else {
      throw InputError(where_, "not a line of a PCD header: '{}'", key.substr(0, 40));
    }
  }

  // Sets worldFromFile from the translation and the quaternion (w first) of a line VIEWPOINT tx ty tz qw qx qy qz.
  // Seven zeros leave the identity.
  void readViewpoint(const Words& words) {
    std::array<double, 7> numbers{};
    if (words.size() != 8) throw InputError(where_, "VIEWPOINT must have seven values: tx ty tz qw qx qy qz");
    for (std::size_t i = 0; i < 7; ++i) readNumber(words[i + 1], numbers[i], "VIEWPOINT", where_);
    const auto [tx, ty, tz, w, x, y, z] = numbers;
    const double norm = std::sqrt(w * w + x * x + y * y + z * z);
    if (norm == 0 && tx == 0 && ty == 0 && tz == 0) return;
    if (!isFinite(Vec3d{tx, ty, tz})) {
      throw InputError(where_, "VIEWPOINT has the translation {} {} {}: it must be finite", tx, ty, tz);
    }
    constexpr double kRounding = 0.01;  // largest deviation of a rounded quaternion's length from 1
    if (!(std::fabs(norm - 1) <= kRounding)) {
      throw InputError(where_,
                       "VIEWPOINT has the quaternion {} {} {} {} (w x y z), of the length {:.4g}, "
                       "where a rotation has the length 1: write 0 0 0 1 0 0 0 for no pose",
                       w, x, y, z, norm);
    }
    header_.worldFromFile = {{w / norm, x / norm, y / norm, z / norm}, {tx, ty, tz}};
  }

  // Calls set(field, word) for each field. Throws InputError unless the line has one word per field after its key.
  template <class Set>
  void perField(const Words& words, Set&& set) {
    if (header_.fields.empty() || words.size() - 1 != header_.fields.size()) {
      throw InputError(where_, "{} has {} values for {} fields", words[0], words.size() - 1, header_.fields.size());
    }
    for (std::size_t i = 0; i < header_.fields.size(); ++i) set(header_.fields[i], words[i + 1]);
  }

  // Checks the complete header, and sets the number of points and the sizes of rows.
  void check() {
    const Location where{where_.file, 0, 0};
    PcdHeader& h = header_;
    if (h.fields.empty()) throw InputError(where, "the header names no fields");
    for (PcdField& field : h.fields) {
      const bool isFloat = field.type == 'F' && (field.size == 4 || field.size == 8);
      const bool isInteger =
          (field.type == 'U' || field.type == 'I') && field.size <= 8 && std::has_single_bit(field.size);
      if (!isFloat && !isInteger) {
        throw InputError(where, "field {} has type {} and size {}: PCD knows F 4 8 and U, I 1 2 4 8", field.name,
                         field.type == 0 ? '?' : field.type, field.size);
      }
    }
    h.setOffsets();
    if (h.rowBytes == 0) throw InputError(where, "the header's fields hold no values: every COUNT is 0");
    h.points = points_.value_or(h.width * h.height);
    if (h.points > UINT32_MAX) {
      throw InputError(where, "{} x {} (WIDTH x HEIGHT) are more than {} points", h.width, h.height, UINT32_MAX);
    }
    if (h.width * h.height != h.points) {
      throw InputError(where, "{} x {} (WIDTH x HEIGHT) are not {} POINTS", h.width, h.height, h.points);
    }
    if (!h.sensor || !h.organised) return;
    const auto [rings, columns] = *h.sensor;
    if (h.width != columns || (rings == 0 ? h.height != 0 : h.height == 0 || h.height % rings != 0)) {
      throw InputError(where, "WIDTH and HEIGHT disagree with the sensor comment");
    }
  }

  std::string_view rest_;
  Location where_;
  PcdHeader header_;
  std::optional<std::uint64_t> points_;  // number of points that the header states
};

class BodyReader {
 public:
  BodyReader(PcdHeader header, const std::string& what, bool exact)
      : header_(std::move(header)), where_{what, 0, 0}, exact_(exact) {
    if (!exact_ || header_.data != "ascii") return;
    // Numbers in a text may have more digits than a float32 can represent: read coordinates as doubles.
    for (PcdField& field : header_.fields) {
      const bool isCoordinate = field.type == 'F' && (field.name == "x" || field.name == "y" || field.name == "z");
      if (isCoordinate) field.size = sizeof(double);
    }
    header_.setOffsets();
  }

  Cloud read() {
    Cloud cloud;
    cloud.worldFromFile = header_.worldFromFile;
    cloud.scan = readBody();
    if (exact_) setPositions(exactPositions_, cloud);
    for (const PcdField& field : header_.fields) {
      if (field.count > 1 && field.name != "_")
        cloud.leftOut.add(fmt::format("fields of several values '{}'", field.name));
    }
    cloud.leftOut.addRest(rest_);
    adoptColumns(cloud, where_);
    return cloud;
  }

 private:
  // Returns a scan with the points, and sets rest_ to the bytes behind the points.
  Scan readBody() {
    if (header_.data == "ascii") return readAscii();
    if (header_.data == "binary") {
      if (header_.points * header_.rowBytes > header_.body.size()) {
        throw InputError(where_, "truncated: {} points of {} bytes need {} bytes, {} are left", header_.points,
                         header_.rowBytes, header_.points * header_.rowBytes, header_.body.size());
      }
      rest_ = header_.body.substr(header_.points * header_.rowBytes);
      return readTable(header_.body.data(), TableOrder::RowByRow);
    }
    if (header_.data == "binary_compressed") return readCompressed();
    throw InputError(where_, "unknown DATA '{}': ascii, binary or binary_compressed", header_.data.substr(0, 40));
  }

  // Returns the field with this name; null if there is none. Throws InputError if it has several values per point.
  const PcdField* find(std::string_view name) const {
    const auto field = std::ranges::find(header_.fields, name, &PcdField::name);
    if (field == header_.fields.end()) return nullptr;
    if (field->count != 1) throw InputError(where_, "field {} has {} values a point", name, field->count);
    return &*field;
  }

  // Returns the field with this name if it becomes a column of the table, otherwise null.
  const PcdField* findColumn(std::string_view name) const {
    const PcdField* const field = find(name);
    return field == nullptr || isForeign(*field) ? nullptr : field;
  }

  // True if the field becomes a foreign column: it is no coordinate and no column of the table, has one value per
  // point, and is not padding, which PCL calls "_". Labels and instances that may be below 0 are foreign until
  // adoptColumns().
  static bool isForeign(const PcdField& field) {
    const bool mayBeNegative = field.type != 'U' && (field.name == kLabel.row.name || field.name == kInstance.row.name);
    return field.count == 1 && field.name != "_" && field.name != "x" && field.name != "y" && field.name != "z" &&
           (mayBeNegative || columnIndex(field.name) == kColumnCount);
  }

  const PcdField& require(std::string_view name) const {
    const PcdField* field = find(name);
    if (field != nullptr) return *field;
    throw InputError(where_,
                     "there is no field {}, but {}: name the coordinates x, y and z in FIELDS; a "
                     "field of three values becomes three in SIZE, TYPE and COUNT, too",
                     name, fmt::join(namesOf(header_.fields), ", "));
  }

  // Returns a scan without points, which has the header's rings and columns and the names of its columns.
  Scan newScan() const {
    require("x"), require("y"), require("z");
    Scan scan;
    scan.organised = header_.sensor ? header_.organised : header_.height > 1;
    std::array<std::uint64_t, 2> ringsAndColumns{0, 0};  // 0: unknown
    if (scan.organised) ringsAndColumns = {header_.height, header_.width};
    const auto [rings, columns] = header_.sensor.value_or(ringsAndColumns);
    scan.rings = static_cast<std::uint32_t>(rings);
    scan.columns = static_cast<std::uint32_t>(columns);
    if (scan.organised && scan.rings > 0) scan.planes = static_cast<std::uint32_t>(header_.height / scan.rings);
    visitTable(scan, [&](auto key, auto&) {
      if (findColumn(key.row.name) != nullptr) scan.columnsIfEmpty.add(key.index);
    });
    for (const PcdField& field : header_.fields) {
      if (!isForeign(field)) continue;
      visitNumberType(field.type, field.size, [&]<class T>(T) {
        scan.foreign.push_back({std::string(field.name), std::vector<T>(header_.points)});
      });
    }
    return scan;
  }

  Scan readCompressed() {
    constexpr std::size_t kSizesBytes = 8;  // bytes of the block's two sizes, compressed and not
    if (header_.body.size() < kSizesBytes) {
      if (header_.points == 0) return newScan();
      throw InputError(where_, "truncated: the compressed sizes are missing");
    }
    const auto packedBytes = numberAt<std::uint32_t>(header_.body, 0);
    const auto tableBytes = numberAt<std::uint32_t>(header_.body, 4);
    const std::string_view packed = header_.body.substr(kSizesBytes);
    if (tableBytes != header_.points * header_.rowBytes) {
      throw InputError(where_, "{} points of {} bytes are not the {} bytes of the compressed block", header_.points,
                       header_.rowBytes, tableBytes);
    }
    if (packedBytes > packed.size()) {
      throw InputError(where_, "truncated: {} compressed bytes are announced, {} are left", packedBytes, packed.size());
    }
    rest_ = packed.substr(packedBytes);
    if (header_.points == 0) return newScan();
    if (tableBytes > packedBytes * kLzfGain) {
      throw InputError(where_, "the compressed block is too short for its points");
    }
    const auto table = std::make_unique_for_overwrite<char[]>(tableBytes);
    if (lzf_decompress(packed.data(), packedBytes, table.get(), tableBytes) != tableBytes) {
      throw InputError(where_, "the compressed block is damaged");
    }
    return readTable(table.get(), TableOrder::FieldByField);
  }

  enum class TableOrder { RowByRow, FieldByField };

  // Returns the scan with the values in `table`, which has the order `order`.
  Scan readTable(const char* table, TableOrder order) {
    Scan scan = newScan();
    const std::size_t points = header_.points;
    const bool byField = order == TableOrder::FieldByField;
    // Sets to[0], to[stride], ... to the values of a field.
    const auto fill = [&]<class T>(const PcdField& field, T* to, std::size_t stride) {
      const char* value = table + field.offset * (byField ? points : 1);
      const std::size_t step = byField ? field.size : header_.rowBytes;  // bytes from value to value
      visitNumberType(field.type, field.size, [&](auto stored) {
        for (std::size_t i = 0; i < points; ++i, value += step, to += stride) {
          std::memcpy(&stored, value, sizeof(stored));
          *to = columnValue<T>(stored, field.name, i, where_);
        }
      });
    };
    const auto fillPositions = [&](auto& positions) {
      positions.resize(points);
      if (points == 0) return;
      fill(require("x"), &positions[0].x, 3);
      fill(require("y"), &positions[0].y, 3);
      fill(require("z"), &positions[0].z, 3);
    };
    exact_ ? fillPositions(exactPositions_) : fillPositions(scan.position);
    if (points == 0) return scan;
    visitTable(scan, [&](auto key, auto& values) {
      const PcdField* field = findColumn(key.row.name);
      if (!field) return;
      values.resize(points);
      fill(*field, values.data(), 1);
    });
    for (ForeignColumn& column : scan.foreign) {
      std::visit([&](auto& values) { fill(*find(column.name), values.data(), 1); }, column.values);
    }
    return scan;
  }

  Scan readAscii() {
    std::string table;  // the points as in a binary file
    std::string_view rest = header_.body;
    Location where{where_.file, header_.bodyLine - 1, 0};
    for (std::size_t point = 0; point < header_.points;) {
      if (rest.empty()) throw InputError(where, "truncated after {} of {} points", point, header_.points);
      ++where.line;
      std::string_view line = takeLine(rest);
      if (line.empty()) continue;
      ++point;
      for (const PcdField& field : header_.fields) {
        for (std::uint64_t element = 0; element < field.count; ++element)
          appendWord(field, takeWord(line), where, table);
      }
      if (!line.empty()) {
        throw InputError(where, "more values than the {} fields have", header_.fields.size());
      }
    }
    rest_ = rest;
    return readTable(table.data(), TableOrder::RowByRow);
  }

  // Appends the number in `word` to `table`, in the field's type. For a field that becomes no column, appends 0.
  static void appendWord(const PcdField& field, std::string_view word, const Location& where, std::string& table) {
    if (word.empty()) throw InputError(where, "there is no value of field {}", field.name);
    visitNumberType(field.type, field.size, [&](auto value) {
      if (field.count == 1 && field.name != "_") readNumber(word, value, field.name, where);
      putNumber(value, table);
    });
  }

  PcdHeader header_;
  Location where_;
  bool exact_;
  std::string_view rest_;              // bytes behind the points
  std::vector<Vec3d> exactPositions_;  // m, positions before the origin is subtracted; empty unless exact_
};

}  // namespace

const FormatSupport kPcdFormat{
    "PCD", ".pcd",
    "Fields of one value a point: see the columns of point clouds; DATA is ascii, binary or binary_compressed. "
    "VIEWPOINT is the pose of the points where the file is an object of a scene; recorded scans stay in the frame of "
    "the sensor",
    "fields of several values; bytes behind the stated contents"};

Cloud readPcd(std::string_view bytes, const std::string& what, bool exact) {
  return BodyReader(HeaderReader(bytes, what).read(), what, exact).read();
}

}  // namespace scanmill
