// csv: comma-separated values. The header line names exactly the columns of the lines below it, in their order.
//
//   x,y,z,intensity,label
//   1.5,-2.25,0.125,37,4
//
// Numbers have the shortest digits that read back to the same bits, lines end with '\n', and misses of an organised
// scan are "nan". The text does not describe the sensor: decode() returns one row per line, and rings and columns are
// unknown. Columns that the table of columns lacks are kept as double-precision numbers. readCsv() reads the text of
// other programs, too.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <functional>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include "config/text.h"
#include "formats/cloud_columns.h"
#include "formats/makers.h"
#include "formats/readers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

// Returns the text without blanks at its ends.
std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

// Returns the cells of a line without quotation marks. The separator ' ' stands for any number of blanks.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (bool more = true; more;) {
    const std::size_t end = separator == ' ' ? line.find_first_of(" \t") : line.find(separator);
    more = end != std::string_view::npos;
    std::string_view cell = trimmed(line.substr(0, end));
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    if (more) line.remove_prefix(end + 1);
    if (separator == ' ') line = trimmed(line);
  }
}

// A function that stores a cell of the file as a value of the point that was added to the scan last.
using ReadCell = std::function<void(std::string_view word, const Location& where)>;

bool isNumber(std::string_view word) {
  double number = 0;
  const char* const end = word.data() + word.size();
  return std::from_chars(word.data(), end, number).ptr == end && !word.empty();
}

class CsvReader {
 public:
  CsvReader(std::string_view bytes, const std::string& what, bool exact)
      : rest_(bytes), lineEnd_(bytes.find('\n') == bytes.npos ? '\r' : '\n'), where_{what, 0, 0}, exact_(exact) {}

  Cloud read() {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    if (!readHeader()) throw InputError({where_.file, 1}, "the file is empty");
    while (nextLine()) {
      split(line_, separator_, cells_);
      if (cloud_.scan.size() == 0 && columns_.size() > 1 && takeCount()) continue;
      if (cells_.size() != columns_.size()) {
        throw InputError(
            where_, fmt::format("{} values where the header names {} columns{}", cells_.size(), columns_.size(),
                                cells_.size() > columns_.size() && separator_ == ',' ? ": decimals need a point" : ""));
      }
      addPoint();
    }
    if (announced_ && *announced_ != cloud_.scan.size()) {
      throw InputError({where_.file}, fmt::format("announces {} points, but has {}: it is not complete", *announced_,
                                                  cloud_.scan.size()));
    }
    if (exact_) setPositions(places_, cloud_);
    adoptColumns(cloud_, {where_.file});
    return std::move(cloud_);
  }

 private:
  // Removes the next line from the rest of the file.
  void cutLine() {
    const std::size_t end = std::min(rest_.find(lineEnd_), rest_.size());
    line_ = trimmed(rest_.substr(0, end));
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++where_.line;
  }

  // Steps to the next line that is neither empty nor a comment. Returns false at the end of the file.
  bool nextLine() {
    while (!rest_.empty()) {
      cutLine();
      if (!line_.empty() && !line_.starts_with('#') && !line_.starts_with("//")) return true;
    }
    return false;
  }

  // Reads the first line of names, which may look like a comment, or else the first point.
  bool readHeader() {
    while (!rest_.empty()) {
      cutLine();
      const bool isComment = line_.starts_with('#') || line_.starts_with("//");
      const std::size_t names = isComment ? line_.find_first_not_of("#/ \t") : 0;
      if (line_.empty() || names == std::string_view::npos) continue;
      line_.remove_prefix(names);
      const std::size_t separator = line_.find_first_of(",;\t");
      separator_ = separator == std::string_view::npos ? ' ' : line_[separator];
      split(line_, separator_, cells_);
      nameAxes();
      if (!isComment && takeCount()) continue;
      if (!isComment || namesPositions()) return readNames();
    }
    return false;
  }

  // Takes a line that holds only the number of points, which some programs write before the first point.
  bool takeCount() {
    const std::string_view cell = cells_[0];
    std::uint64_t count = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), count);
    if (cells_.size() != 1 || announced_ || error != std::errc() || end != cell.data() + cell.size()) return false;
    announced_ = count;
    return true;
  }

  // Names the axes of a survey, and those of ParaView, x, y and z.
  void nameAxes() {
    const auto called = [&](std::initializer_list<const char*> names) {
      return std::find_if(cells_.begin(), cells_.end(), [&](std::string_view cell) {
        return std::find(names.begin(), names.end(), lowerCase(cell)) != names.end();
      });
    };
    const auto east = called({"easting", "points:0"}), north = called({"northing", "points:1"});
    const auto up = called({"z", "elevation", "height", "altitude", "points:2"});
    if (east == cells_.end() || north == cells_.end() || up == cells_.end() || called({"x"}) != cells_.end()) return;
    *east = "x";
    *north = "y";
    *up = "z";
  }

  bool namesPositions() const {
    return std::all_of(kAxes.begin(), kAxes.end(), [&](const auto& axis) {
      return std::any_of(cells_.begin(), cells_.end(),
                         [&](std::string_view cell) { return columnMeant(cell) == axis.first; });
    });
  }

  bool readNames() {
    if (cells_.size() == 3 && std::all_of(cells_.begin(), cells_.end(), isNumber)) {
      for (const auto& [name, member] : kAxes) columns_.push_back(cellReader(std::string(name)));
      addPoint();
      return true;
    }
    constexpr std::size_t kMostColumns = 256;
    if (cells_.size() > kMostColumns) throw InputError(where_, "the header names too many columns to be a scan's");
    const bool placed = namesPositions();
    std::vector<std::string> names;
    for (const std::string_view cell : cells_) {
      const bool word = !cell.empty() && std::all_of(cell.begin(), cell.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
      });
      const bool isName = word && std::isdigit(static_cast<unsigned char>(cell.front())) == 0;
      if (!isName && !placed) {
        throw InputError(where_, fmt::format("'{}' is no name of a column: the first line names them, as x,y,z,label; "
                                             "only files of x, y and z alone do without",
                                             cell.substr(0, 40)));
      }
      const std::string lower = columnMeant(cell);
      const bool isAxis = lower == "x" || lower == "y" || lower == "z";
      names.push_back(isAxis ? lower : isName ? std::string(cell) : nameFor(cell));
      if (std::count(names.begin(), names.end(), names.back()) > 1) {
        throw InputError(where_, fmt::format("column '{}' is named twice", names.back()));
      }
      columns_.push_back(cellReader(names.back()));
    }
    for (const auto& [axis, member] : kAxes) {
      if (std::find(names.begin(), names.end(), axis) == names.end()) {
        throw InputError(where_, fmt::format("there is no column '{}'", axis));
      }
    }
    return true;
  }

  // Returns a name of letters, digits and underscores for a column that other programs call `cell`.
  std::string nameFor(std::string_view cell) const {
    if (cell.empty()) return fmt::format("column_{}", columns_.size() + 1);
    std::string name(cell);
    std::replace_if(
        name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    return std::isdigit(static_cast<unsigned char>(name.front())) == 0 ? name : "_" + name;
  }

  // Returns the function that stores the cells of the column with this name. A name that is not in the table of columns
  // becomes a foreign column.
  ReadCell cellReader(const std::string& name) {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      if (name != kAxes[axis].first) continue;
      return [this, axis](std::string_view word, const Location& where) {
        if (exact_) {
          readNumber(word, places_.back().*kAxes[axis].second, kAxes[axis].first, where);
        } else {
          readNumber(word, cloud_.scan.position.back().*kFloatAxes[axis], kAxes[axis].first, where);
        }
      };
    }
    ReadCell read;
    visitTable(cloud_.scan, [&]<class Value>(auto key, std::vector<Value>& values) {
      if (key.row.name != name) return;
      if (key.index == kLabel.index || key.index == kInstance.index) {
        // adoptColumns() takes the numbers below 0 for none.
        read = [numbers = foreignReader(name), name](std::string_view word, const Location& where) {
          Value fits = 0;
          if (!word.starts_with('-')) readNumber(word, fits, name, where);
          numbers(word, where);
        };
        return;
      }
      cloud_.scan.columnsIfEmpty.add(key.index);
      read = [&values, key](std::string_view word, const Location& where) {
        readNumber(word, values.emplace_back(), key.row.name, where);
      };
    });
    if (read) return read;
    if (cloudColumns().find(columnMeant(name)) != nullptr) return foreignReader(name);
    return [this, numbers = foreignReader(name), texts = fmt::format("texts in the column '{}'", name)](
               std::string_view word, const Location& where) {
      const bool isText = !isNumber(word.substr(word.starts_with('+') ? 1 : 0));
      if (isText) cloud_.leftOut.add(texts);
      numbers(isText ? "nan" : word, where);
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
    if (exact_) places_.emplace_back();
    for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i](cells_[i], where_);
  }

  static constexpr std::array<std::pair<std::string_view, double Vec3d::*>, 3> kAxes{
      {{"x", &Vec3d::x}, {"y", &Vec3d::y}, {"z", &Vec3d::z}}};
  static constexpr std::array<float Vec3f::*, 3> kFloatAxes{&Vec3f::x, &Vec3f::y, &Vec3f::z};

  std::string_view rest_, line_;
  char lineEnd_;  // '\r' in texts of classic Mac OS
  Location where_;
  bool exact_;
  char separator_ = ',';
  std::optional<std::uint64_t> announced_;  // the number of points, if the file states it
  std::vector<std::string_view> cells_;
  std::vector<ReadCell> columns_;
  std::vector<Vec3d> places_;  // m, positions before the origin is subtracted; empty unless exact_
  Cloud cloud_;
};

class Csv : public Format {
 public:
  std::string_view suffix() const override { return "csv"; }
  double maxError() const override { return 0; }
  bool keepsMisses() const override { return true; }

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

const FormatSupport& csvFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "Text",
      ".csv, .xyz, .asc",
      {{Read, "x y z", "and the columns of point clouds, as the first line names them; without names: x y z"},
       {Read, "easting northing elevation", "positions of surveys; height and altitude, too"},
       {Read, "", "the number of points, alone in the line before the first point, as CloudCompare writes it"},
       {LeftOut, "", "texts in columns that are none of point clouds"},
       {Read, ", ;", "separators, as in the first line; tabs and blanks are, too"},
       {Unused, "# //", "comments; the first of them may hold the names"}}};
  return format;
}

Cloud readCsv(std::string_view bytes, const std::string& what, bool exact) {
  return CsvReader(bytes, what, exact).read();
}

}  // namespace scanmill
