#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "config/text.h"
#include "formats/cloud_columns.h"
#include "formats/column_value.h"
#include "formats/ply_header.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {
namespace {

// One property of all vertices.
struct PlyColumn {
  std::string name;
  PlyType type;
  PlyType count;               // of a list, whose values are skipped
  std::vector<double> values;  // empty for a list

  bool isList() const { return count.size > 0; }
};

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file)
      : file_(file), where_{file.string()}, header_(readPlyHeader(file)), bytes_(readFile(file)) {}

  Cloud read() {
    const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header_.elements.end()) fail("has no element vertex: it holds no points");
    for (const PlyProperty& p : vertex->properties) {
      const auto is = [&](const PlyColumn& c) { return c.name == p.name; };
      if (std::any_of(columns_.begin(), columns_.end(), is)) fail(fmt::format("has two properties '{}'", p.name));
      columns_.push_back({p.name, p.value, p.count, {}});
      if (p.isList()) cloud_.leftOut.add(fmt::format("lists at vertices '{}'", p.name));
    }
    for (const PlyElement& e : header_.elements) {
      if (e.name != "vertex") cloud_.leftOut.addKeyword(plyCloudFormat(), e.count == 0 ? "face" : e.name);
    }
    if (header_.format == PlyHeader::Format::Ascii) {
      readLines(vertex);
    } else {
      readBinary(vertex);
    }
    build(vertex->count);
    return std::move(cloud_);
  }

 private:
  using Element = std::vector<PlyElement>::const_iterator;
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  // Reads the next number of a binary file.
  double next(const PlyType& type) {
    if (type.size > bytes_.size() - at_) failTruncated();
    at_ += type.size;
    return numberAt(at_ - type.size, type);
  }

  [[noreturn]] void failTruncated() const { fail("is truncated or damaged: it ends before its last vertex"); }

  void skipList(const PlyType& count, const PlyType& value) {
    const double length = next(count);
    const double most = static_cast<double>(bytes_.size() - at_) / static_cast<double>(value.size);
    if (!(length >= 0 && length <= most)) failTruncated();
    at_ += static_cast<std::uint64_t>(length) * value.size;
  }

  void readBinary(Element vertex) {
    at_ = header_.size;
    for (auto e = header_.elements.cbegin(); e != vertex; ++e) {
      for (std::uint64_t i = 0; i < e->count; ++i) {
        for (const PlyProperty& p : e->properties) p.isList() ? skipList(p.count, p.value) : void(next(p.value));
      }
    }
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
      for (PlyColumn& column : columns_) {
        if (column.isList()) {
          skipList(column.count, column.type);
        } else {
          column.values.push_back(next(column.type));
        }
      }
    }
  }

  double numberAt(std::uint64_t at, const PlyType& type) const {
    const bool big = header_.format == PlyHeader::Format::BigEndian;
    std::uint64_t bits = 0;
    for (std::uint64_t i = 0; i < type.size; ++i) {
      const auto byte = static_cast<unsigned char>(bytes_[at + i]);
      bits |= std::uint64_t{byte} << 8 * (big ? type.size - 1 - i : i);
    }
    if (type.kind == PlyType::Kind::Float) {
      return type.size == 8 ? std::bit_cast<double>(bits)
                            : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    // Integers have at most four bytes, which a double represents exactly.
    const double range = std::ldexp(1.0, static_cast<int>(8 * type.size));
    const auto value = static_cast<double>(bits);
    return type.kind == PlyType::Kind::Signed && value >= range / 2 ? value - range : value;
  }

  void readLines(Element vertex) {
    std::string_view rest = std::string_view(bytes_).substr(header_.size);
    const char end = header_.isMac ? '\r' : '\n';
    std::uint64_t skipped = 0;
    for (auto e = header_.elements.cbegin(); e != vertex; ++e) skipped += e->count;
    Location where{file_.string(), header_.lines};
    for (std::uint64_t i = 0; i < skipped + vertex->count; ++i) {
      if (rest.empty())
        fail(fmt::format("is truncated: it ends before vertex {} of {}", i - skipped + 1, vertex->count));
      const std::size_t length = std::min(rest.find(end), rest.size());
      std::string_view line = rest.substr(0, length);
      rest.remove_prefix(std::min(length + 1, rest.size()));
      ++where.line;
      if (i < skipped) continue;
      const auto number = [&](std::string_view name) {
        double value = 0;
        readNumber(cutWord(line), value, name, where);
        return value;
      };
      for (PlyColumn& column : columns_) {
        const double first = number(column.name);
        if (!column.isList()) {
          column.values.push_back(first);
          continue;
        }
        if (!(first >= 0)) throw InputError(where, fmt::format("the list '{}' has the length {}", column.name, first));
        for (double left = first; left > 0; --left) number(column.name);
      }
      if (!cutWord(line).empty()) {
        throw InputError(where, fmt::format("has more values than a vertex has properties ({})", columns_.size()));
      }
    }
  }

  // Removes the first word from a line and returns it; empty at the end of the line.
  static std::string_view cutWord(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
    line.remove_prefix(word.size());
    return word;
  }

  const PlyColumn& require(const char* name) const {
    const auto found = std::find_if(columns_.begin(), columns_.end(),
                                    [&](const PlyColumn& c) { return columnMeant(c.name) == name && !c.isList(); });
    if (found == columns_.end()) fail(fmt::format("has no property {}", name));
    return *found;
  }

  void build(std::uint64_t count) {
    const PlyColumn& x = require("x");
    const PlyColumn& y = require("y");
    const PlyColumn& z = require("z");
    std::vector<Vec3d> places;
    for (std::uint64_t i = 0; i < count; ++i) places.push_back({x.values[i], y.values[i], z.values[i]});
    setPositions(places, cloud_);
    std::vector<ForeignColumn>& foreign = cloud_.scan.foreign;
    for (const PlyColumn& column : columns_) {
      if (&column == &x || &column == &y || &column == &z || column.isList()) continue;
      foreign.push_back({column.name, valuesOf(column)});
    }
    adoptColumns(cloud_, where_);
    for (ForeignColumn& column : foreign) {
      std::string name = columnMeant(column.name);
      const bool taken = columnIndex(name) < kColumnCount ||
                         std::any_of(foreign.begin(), foreign.end(), [&](const auto& f) { return f.name == name; });
      column.name = taken ? lowerCase(column.name) : std::move(name);
    }
  }

  ForeignColumn::Values valuesOf(const PlyColumn& column) const {
    const auto as = [&]<class T>(T) {
      std::vector<T> values;
      for (const double value : column.values) {
        values.push_back(columnValue<T>(value, column.name, values.size(), where_));
      }
      return values;
    };
    const bool isSigned = column.type.kind == PlyType::Kind::Signed;
    if (column.type.kind == PlyType::Kind::Float) {
      return column.type.size == 8 ? ForeignColumn::Values(as(double{})) : ForeignColumn::Values(as(float{}));
    }
    switch (column.type.size) {
      case 1:
        return isSigned ? ForeignColumn::Values(as(std::int8_t{})) : ForeignColumn::Values(as(std::uint8_t{}));
      case 2:
        return isSigned ? ForeignColumn::Values(as(std::int16_t{})) : ForeignColumn::Values(as(std::uint16_t{}));
      default:
        return isSigned ? ForeignColumn::Values(as(std::int32_t{})) : ForeignColumn::Values(as(std::uint32_t{}));
    }
  }

  const std::filesystem::path& file_;
  Location where_;
  PlyHeader header_;
  std::string bytes_;
  std::uint64_t at_ = 0;  // offset of the next number of a binary file
  std::vector<PlyColumn> columns_;
  Cloud cloud_;
};

}  // namespace

const FormatSupport& plyCloudFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{"PLY of points",
                                    ".ply without faces",
                                    {{Read, "vertex", "points: their properties are the columns of point clouds"},
                                     {Unused, "face tristrips camera", "empty elements, and the camera of MeshLab"},
                                     {LeftOut, "edge", "elements 'edge'"},
                                     {LeftOut, "", "lists at vertices"}}};
  return format;
}

Cloud readPly(const std::filesystem::path& file) {
  return PlyReader(file).read();
}

}  // namespace scanmill
