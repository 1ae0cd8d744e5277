#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "config/text.h"
#include "formats/column_value.h"
#include "formats/ply_header.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {
namespace {

// Returns the name of a property's column: the property's name in lower case and without CloudCompare's prefix. A
// synonym in kOthers is replaced by the usual name, which kOthers gives beside it.
std::string columnNameOf(const std::string& property) {
  static const std::map<std::string, std::string> kOthers{{"class", "label"},
                                                          {"classification", "label"},
                                                          {"semantic", "label"},
                                                          {"semantics", "label"},
                                                          {"sem_class", "label"},
                                                          {"instance_id", "instance"},
                                                          {"reflectance", "intensity"},
                                                          {"reflectivity", "intensity"},
                                                          {"r", "red"},
                                                          {"g", "green"},
                                                          {"b", "blue"},
                                                          {"diffuse_red", "red"},
                                                          {"diffuse_green", "green"},
                                                          {"diffuse_blue", "blue"},
                                                          {"normal_x", "nx"},
                                                          {"normal_y", "ny"},
                                                          {"normal_z", "nz"}};
  constexpr std::string_view kPrefix = "scalar_";
  std::string name = lowerCase(property);
  if (name.starts_with(kPrefix)) name = name.substr(kPrefix.size());
  const auto other = kOthers.find(name);
  return other == kOthers.end() ? name : other->second;
}

// One property of all vertices.
struct PlyColumn {
  std::string name;
  PlyType type;
  std::vector<double> values;
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file)
      : file_(file), where_{file.string()}, header_(readPlyHeader(file)), bytes_(readFile(file)) {}

  Cloud read() {
    const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header_.elements.end()) fail("has no element vertex: it holds no points");
    for (auto e = header_.elements.begin(); e <= vertex; ++e) {
      for (const PlyProperty& p : e->properties) {
        if (p.isList())
          fail(fmt::format("has the list '{}' of '{}', behind which no points are read", p.name, e->name));
      }
    }
    for (const PlyProperty& p : vertex->properties) {
      columns_.push_back({columnNameOf(p.name), p.value, {}});
      const auto twice = std::count_if(columns_.begin(), columns_.end(),
                                       [&](const PlyColumn& c) { return c.name == columns_.back().name; });
      if (twice > 1) fail(fmt::format("has two properties that mean {}", columns_.back().name));
    }
    if (header_.format == PlyHeader::Format::Ascii) {
      readLines(vertex);
    } else {
      readBinary(vertex);
    }
    return build(vertex->count);
  }

 private:
  using Element = std::vector<PlyElement>::const_iterator;
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  static std::uint64_t rowBytes(const PlyElement& element) {
    std::uint64_t bytes = 0;
    for (const PlyProperty& p : element.properties) bytes += p.value.size;
    return bytes;
  }

  void readBinary(Element vertex) {
    std::uint64_t at = header_.size;
    for (auto e = header_.elements.cbegin(); e != vertex; ++e) at += e->count * rowBytes(*e);
    if (at > bytes_.size() || vertex->count * rowBytes(*vertex) > bytes_.size() - at) {
      fail(fmt::format("is truncated: {} vertices of {} bytes do not fit into it", vertex->count, rowBytes(*vertex)));
    }
    for (PlyColumn& column : columns_) column.values.reserve(vertex->count);
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
      for (PlyColumn& column : columns_) {
        column.values.push_back(numberAt(at, column.type));
        at += column.type.size;
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
      for (PlyColumn& column : columns_) {
        line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
        const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
        line.remove_prefix(word.size());
        double number = 0;
        readNumber(word, number, column.name, where);
        column.values.push_back(number);
      }
    }
  }

  const PlyColumn& require(const char* name) const {
    const auto found =
        std::find_if(columns_.begin(), columns_.end(), [&](const PlyColumn& c) { return c.name == name; });
    if (found == columns_.end()) fail(fmt::format("has no property {}", name));
    return *found;
  }

  Cloud build(std::uint64_t count) const {
    Cloud cloud;
    const PlyColumn& x = require("x");
    const PlyColumn& y = require("y");
    const PlyColumn& z = require("z");
    for (std::uint64_t i = 0; i < count; ++i) {
      if (!std::isfinite(x.values[i] + y.values[i] + z.values[i])) continue;
      cloud.origin = cloudOrigin({x.values[i], y.values[i], z.values[i]});
      break;
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      cloud.scan.position.push_back(static_cast<Vec3f>(Vec3d{x.values[i], y.values[i], z.values[i]} - cloud.origin));
    }
    for (const PlyColumn& column : columns_) {
      if (column.name == "x" || column.name == "y" || column.name == "z") continue;
      if (columnIndex(column.name) == kColumnCount) {
        cloud.scan.foreign.push_back({column.name, valuesOf(column)});
        continue;
      }
      visitTable(cloud.scan, [&]<class Key, class Values>(Key key, Values& values) {
        if (key.row.name != column.name) return;
        for (std::size_t i = 0; i < column.values.size(); ++i) {
          values.push_back(columnValue<typename Values::value_type>(column.values[i], column.name, i, where_));
        }
      });
    }
    return cloud;
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
  std::vector<PlyColumn> columns_;
};

}  // namespace

Cloud readPly(const std::filesystem::path& file) {
  return Reader(file).read();
}

}  // namespace scanmill
