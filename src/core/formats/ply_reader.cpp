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
    const auto vertex = std::ranges::find(header_.elements, "vertex", &PlyElement::name);
    if (vertex == header_.elements.end()) fail("has no element vertex: it holds no points");
    for (const PlyProperty& property : vertex->properties) {
      const auto isSameName = [&](const PlyColumn& column) { return column.property.name == property.name; };
      if (std::ranges::any_of(columns_, isSameName)) fail(fmt::format("has two properties '{}'", property.name));
      columns_.push_back({property, {}});
      if (property.isList()) cloud_.leftOut.add(fmt::format("lists at vertices '{}'", property.name));
    }
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex") continue;
      cloud_.leftOut.addKeyword(kPlyCloudFormat, element.count == 0 ? "face" : element.name);
    }
    readRows(vertex);
    build(vertex->count);
    return std::move(cloud_);
  }

 private:
  using Element = std::vector<PlyElement>::const_iterator;
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  // Skips the elements before `vertex`, and reads its rows into columns_.
  void readRows(Element vertex) {
    for (auto element = header_.elements.cbegin(); element != vertex; ++element) {
      for (std::uint64_t row = 0; row < element->count; ++row) {
        body_.beginRow(*element, row);
        if (header_.format == PlyHeader::Format::Ascii) continue;
        for (const PlyProperty& property : element->properties) body_.skip(property);
      }
    }
    for (std::uint64_t row = 0; row < vertex->count; ++row) {
      body_.beginRow(*vertex, row);
      for (auto& [property, values] : columns_) {
        property.isList() ? body_.skip(property) : values.push_back(body_.number(property));
      }
      body_.endRow();
    }
    const bool isLast = std::all_of(vertex + 1, header_.elements.cend(), [](const auto& e) { return e.count == 0; });
    if (isLast) cloud_.leftOut.addRest(body_.rest());
  }

  // Returns the column that the file has for the coordinate `name`. Throws InputError if there is none.
  const PlyColumn& require(const char* name) const {
    const auto column = std::ranges::find_if(
        columns_, [&](const PlyColumn& c) { return columnMeant(c.property.name) == name && !c.property.isList(); });
    if (column == columns_.end()) fail(fmt::format("has no property {}", name));
    return *column;
  }

  // Builds the cloud of `count` points from columns_. Foreign columns get the name columnMeant() unless it is taken.
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
      visitNumberType(column.property.value.kind, column.property.value.size, [&]<class T>(T) {
        std::vector<T> values;
        for (const double value : column.values) {
          values.push_back(columnValue<T>(value, column.property.name, values.size(), where_));
        }
        foreign.push_back({column.property.name, std::move(values)});
      });
    }
    adoptColumns(cloud_, where_);
    for (ForeignColumn& column : foreign) {
      std::string name = columnMeant(column.name);
      const bool isTaken =
          columnIndex(name) < kColumnCount || std::ranges::find(foreign, name, &ForeignColumn::name) != foreign.end();
      column.name = isTaken ? lowerCase(column.name) : std::move(name);
    }
  }

  Location where_;
  PlyHeader header_;
  std::string bytes_;
  PlyBody body_;
  std::vector<PlyColumn> columns_;
  Cloud cloud_;
};

}  // namespace

const FormatSupport kPlyCloudFormat{
    "PLY of points",
    ".ply without faces",
    "Points, whose properties are the columns of point clouds. Empty elements and the camera of MeshLab change nothing",
    "lists at vertices; bytes behind the stated contents",
    {.read = {"vertex"}, .unused = {"face tristrips camera"}, .leftOut = {{"edge", "elements 'edge'"}}}};

Cloud readPly(const std::filesystem::path& file) {
  return PlyReader(file).read();
}

}  // namespace scanmill
