#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "config/text.h"
#include "formats/ply_file.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {
namespace {

// One property of all vertices.
struct PlyColumn {
  const PlyProperty& property;
  std::vector<double> values;  // empty for a list
};

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file)
      : where_{file.string()}, header_(readPlyHeader(file)), bytes_(readFile(file)), body_(file, header_, bytes_) {}

  Cloud read() {
    const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header_.elements.end()) fail("has no element vertex: it holds no points");
    for (const PlyProperty& p : vertex->properties) {
      const auto is = [&](const PlyColumn& c) { return c.property.name == p.name; };
      if (std::any_of(columns_.begin(), columns_.end(), is)) fail(fmt::format("has two properties '{}'", p.name));
      columns_.push_back({p, {}});
      if (p.isList()) cloud_.leftOut.add(fmt::format("lists at vertices '{}'", p.name));
    }
    for (const PlyElement& e : header_.elements) {
      if (e.name != "vertex") cloud_.leftOut.addKeyword(plyCloudFormat(), e.count == 0 ? "face" : e.name);
    }
    readRows(vertex);
    build(vertex->count);
    return std::move(cloud_);
  }

 private:
  using Element = std::vector<PlyElement>::const_iterator;
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  void readRows(Element vertex) {
    for (auto e = header_.elements.cbegin(); e != vertex; ++e) {
      for (std::uint64_t i = 0; i < e->count; ++i) {
        body_.beginRow(*e, i);
        if (header_.format == PlyHeader::Format::Ascii) continue;
        for (const PlyProperty& p : e->properties) body_.skip(p);
      }
    }
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
      body_.beginRow(*vertex, i);
      for (auto& [property, values] : columns_) {
        property.isList() ? body_.skip(property) : values.push_back(body_.number(property));
      }
      body_.endRow();
    }
    const bool isLast = std::all_of(vertex + 1, header_.elements.cend(), [](const auto& e) { return e.count == 0; });
    if (isLast) cloud_.leftOut.addRest(body_.rest());
  }

  const PlyColumn& require(const char* name) const {
    const auto found = std::find_if(columns_.begin(), columns_.end(), [&](const PlyColumn& c) {
      return columnMeant(c.property.name) == name && !c.property.isList();
    });
    if (found == columns_.end()) fail(fmt::format("has no property {}", name));
    return *found;
  }

  void build(std::uint64_t count) {
    const PlyColumn& x = require("x");
    const PlyColumn& y = require("y");
    const PlyColumn& z = require("z");
    std::vector<Vec3d> positions;
    for (std::uint64_t i = 0; i < count; ++i) positions.push_back({x.values[i], y.values[i], z.values[i]});
    setPositions(positions, cloud_);
    std::vector<ForeignColumn>& foreign = cloud_.scan.foreign;
    for (const PlyColumn& column : columns_) {
      if (&column == &x || &column == &y || &column == &z || column.property.isList()) continue;
      foreign.push_back({column.property.name, valuesOf(column)});
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
    return visitNumberType(column.property.value.kind, column.property.value.size, [&]<class T>(T) {
      std::vector<T> values;
      for (const double value : column.values) {
        values.push_back(columnValue<T>(value, column.property.name, values.size(), where_));
      }
      return ForeignColumn::Values(std::move(values));
    });
  }

  Location where_;
  PlyHeader header_;
  std::string bytes_;
  PlyBody body_;
  std::vector<PlyColumn> columns_;
  Cloud cloud_;
};

}  // namespace

const FormatSupport& plyCloudFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "PLY of points",
      ".ply without faces",
      {{Read, "vertex"}, {Unused, "face tristrips camera"}, {LeftOut, "edge", "elements 'edge'"}},
      "Points, whose properties are the columns of point clouds. Empty elements and the camera of MeshLab change "
      "nothing",
      "lists at vertices; bytes behind the stated contents"};
  return format;
}

Cloud readPly(const std::filesystem::path& file) {
  return PlyReader(file).read();
}

}  // namespace scanmill
