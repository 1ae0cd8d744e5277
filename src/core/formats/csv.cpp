// csv: comma-separated values. The header line names exactly the columns of the lines below it, in their order.
//
//   x,y,z,intensity,label
//   1.5,-2.25,0.125,37,4
//
// Numbers have the shortest digits that read back to the same bits, lines end with '\n', and misses of an organised
// scan are "nan". The text does not describe the sensor: decode() returns one row per line, and rings and columns are
// unknown. Columns that the table of columns lacks are kept as doubles. readCsv() also reads the text of other
// programs.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <utility>
#include <vector>

#include "base/text_scan.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

// A function that stores a cell of the file as a value of the latest point of the scan.
using ReadCell = std::function<void(std::string_view word, const Location& where)>;

bool isNumber(std::string_view word) {
  double number = 0;
  return parseNumber(word, number);
}

class CsvReader {
 public:
  CsvReader(std::string_view bytes, const std::string& what, bool exact)
      : rest_(textOfFile(bytes)), where_{what, 0, 0}, exact_(exact) {}

  Cloud read() {
    if (!readHeader()) throw InputError({where_.file, 1}, "the file is empty");
    while (!rest_.empty()) {
      nextLine();
      if (line_.empty() || isComment()) continue;
      splitCells(line_, separator_, cells_);
      if (cells_.size() != columns_.size()) {
        throw InputError(where_, "{} values where the header names {} columns{}", cells_.size(), columns_.size(),
                         cells_.size() > columns_.size() && separator_ == ',' ? ": decimals need a point" : "");
      }
      addPoint();
    }
    if (exact_) setPositions(exactPositions_, cloud_);
    adoptColumns(cloud_, {where_.file});
    return std::move(cloud_);
  }

 private:
  void nextLine() {
    line_ = takeLine(rest_);
    ++where_.line;
  }

  bool isComment() const { return line_.starts_with('#') || line_.starts_with("//"); }

  // Reads up to the line that names the columns, which may look like a comment, or up to the first point. Returns false
  // if the file has no such line.
  bool readHeader() {
    while (!rest_.empty()) {
      nextLine();
      const bool comment = isComment();
      line_.remove_prefix(std::min(comment ? line_.find_first_not_of("#/ \t") : 0, line_.size()));
      if (line_.empty()) continue;
      const std::size_t separator = line_.find_first_of(",;\t");
      separator_ = separator == std::string_view::npos ? ' ' : line_[separator];
      splitCells(line_, separator_, cells_);
      const bool namesAxes = std::ranges::all_of(
          kAxes, [&](const auto& axis) { return std::ranges::find(cells_, axis.first, columnMeant) != cells_.end(); });
      if (comment && !namesAxes) continue;
      readNames(namesAxes);
      return true;
    }
    return false;
  }

  // Sets columns_ from the cells of the line. If the cells are three numbers, they are the first point. `namesAxes`:
  // true if cells are called x, y and z.
  void readNames(bool namesAxes) {
    if (cells_.size() == 3 && std::ranges::all_of(cells_, isNumber)) {
      for (const auto& [name, member] : kAxes) columns_.push_back(cellReader(std::string(name)));
      addPoint();
      return;
    }
    if (!namesAxes) {
      throw InputError(where_,
                       "no columns x, y and z: the first line must name them, as x,y,z,label, not '{}'; only "
                       "files of x, y and z alone do without names",
                       line_.substr(0, 60));
    }
    constexpr std::size_t kMostColumns = 256;
    if (cells_.size() > kMostColumns) throw InputError(where_, "the header names too many columns to be a scan's");
    std::vector<std::string> names;
    for (const std::string_view cell : cells_) {
      const std::string meant = columnMeant(cell);
      names.push_back(meant == "x" || meant == "y" || meant == "z" ? meant : nameFor(cell));
      if (std::ranges::count(names, names.back()) > 1) {
        throw InputError(where_, "column '{}' is named twice", names.back());
      }
      columns_.push_back(cellReader(names.back()));
    }
  }

  // Returns a name of letters, digits and underscores for a column that other programs call `cell`.
  std::string nameFor(std::string_view cell) const {
    if (cell.empty()) return fmt::format("column_{}", columns_.size() + 1);
    std::string name(cell);
    std::ranges::replace_if(
        name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    return std::isdigit(static_cast<unsigned char>(name.front())) == 0 ? name : "_" + name;
  }

  // Returns the function that stores the cells of the column with this name: a coordinate, a column of the table or,
  // for other names, a foreign column. Texts in a foreign column become NaN, and are counted as left out, unless
  // kCloudColumns lists the column.
  ReadCell cellReader(const std::string& name) {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      if (name != kAxes[axis].first) continue;
      return [this, axis](std::string_view word, const Location& where) {
        if (exact_) readNumber(word, exactPositions_.back().*kAxes[axis].second, kAxes[axis].first, where);
        if (!exact_) readNumber(word, cloud_.scan.position.back().*kFloatAxes[axis], kAxes[axis].first, where);
      };
    }
    ReadCell readTableCell;  // empty: the table lacks the column
    visitTable(cloud_.scan, [&]<class Value>(auto key, std::vector<Value>& values) {
      if (key.row.name != name) return;
      if (key.index == kLabel.index || key.index == kInstance.index) {
        // The column is foreign until adoptColumns() replaces its negative numbers, which mean "no value".
        readTableCell = [readForeign = foreignReader(name), name](std::string_view word, const Location& where) {
          Value ignored = 0;  // the number must fit the column's type
          if (!word.starts_with('-')) readNumber(word, ignored, name, where);
          readForeign(word, where);
        };
        return;
      }
      cloud_.scan.columnsIfEmpty.add(key.index);
      readTableCell = [&values, key](std::string_view word, const Location& where) {
        readNumber(word, values.emplace_back(), key.row.name, where);
      };
    });
    if (readTableCell) return readTableCell;
    if (kCloudColumns.useOf(columnMeant(name)) != FormatSupport::Use::Unknown) return foreignReader(name);
    return [this, readForeign = foreignReader(name), texts = fmt::format("texts in the column '{}'", name)](
               std::string_view word, const Location& where) {
      const bool isText = !isNumber(word);
      if (isText) cloud_.leftOut.add(texts);
      readForeign(isText ? "nan" : word, where);
    };
  }

  // Adds a foreign column. Returns the function that stores its cells.
  ReadCell foreignReader(const std::string& name) {
    cloud_.scan.foreign.push_back({name, std::vector<double>{}});
    return [this, index = cloud_.scan.foreign.size() - 1](std::string_view word, const Location& where) {
      ForeignColumn& column = cloud_.scan.foreign[index];
      readNumber(word, std::get<std::vector<double>>(column.values).emplace_back(), column.name, where);
    };
  }

  void addPoint() {
    cloud_.scan.position.emplace_back();
    if (exact_) exactPositions_.emplace_back();
    for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i](cells_[i], where_);
  }

  static constexpr std::array<std::pair<std::string_view, double Vec3d::*>, 3> kAxes{
      {{"x", &Vec3d::x}, {"y", &Vec3d::y}, {"z", &Vec3d::z}}};
  static constexpr std::array<float Vec3f::*, 3> kFloatAxes{&Vec3f::x, &Vec3f::y, &Vec3f::z};

  std::string_view rest_;  // the file's bytes behind line_
  std::string_view line_;  // the current line
  Location where_;         // location of the current line
  bool exact_;             // see readers.h
  char separator_ = ',';
  std::vector<std::string_view> cells_;  // cells of the current line
  std::vector<ReadCell> columns_;        // by cell
  std::vector<Vec3d> exactPositions_;    // m, positions before the origin is subtracted; empty unless exact_
  Cloud cloud_;
};

class Csv : public Format {
 public:
  double mostBytes(const ScanOutline& outline) const override {
    const std::string header = fmt::format("x,y,z,{}\n", fmt::join(outline.held.names(), ","));
    return static_cast<double>(header.size()) +
           static_cast<double>(outline.points) * static_cast<double>(longestRow(outline.held));
  }

  std::string encode(const Scan& scan) const override {
    requireConsistent(scan);
    std::string out = fmt::format("{}\n", fmt::join(columnNames(scan), ","));
    appendRows(scan, ',', out);
    return out;
  }

  Scan decode(std::string_view bytes, const std::string& what) const override {
    return scanOf(readCsv(bytes, what, false), what);
  }
};

}  // namespace

std::unique_ptr<Format> makeCsv(Fields& options) {
  options.finish();
  return std::make_unique<Csv>();
}

const FormatSupport kCsvFormat{
    "Text", ".csv, .xyz, .asc",
    "x, y, z and the columns of point clouds, as the first line names them, which may be a comment (# or //); "
    "without names: x y z. Commas, semicolons, tabs or blanks separate, as in the first line",
    "texts in columns that are none of point clouds"};

Cloud readCsv(std::string_view bytes, const std::string& what, bool exact) {
  return CsvReader(bytes, what, exact).read();
}

}  // namespace scanmill
