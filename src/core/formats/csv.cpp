// csv: comma-separated values. The header line names exactly the columns of the lines below it, in their order.
//
//   x,y,z,intensity,label
//   1.5,-2.25,0.125,37,4
//
// Numbers have the shortest digits that read back to the same bits, lines end with '\n' ("\r\n" is read as well), and
// misses of an organised scan are "nan". The text does not describe the sensor: decode() returns one row per line, and
// rings and columns are unknown. Columns that the table of columns lacks are kept as double-precision numbers.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <vector>

#include "formats/makers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

// Removes the text up to and including the next `separator` from `text`, and returns it without the separator. If there
// is no separator, removes and returns all of the text.
std::string_view cut(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view piece = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return piece;
}

// Removes the first line from `text` and returns it without its end, "\n" or (from other programs) "\r\n".
std::string_view cutLine(std::string_view& text) {
  std::string_view line = cut(text, '\n');
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// A function that stores a cell of the file as a value of the point that was added to the scan last.
using ReadCell = std::function<void(std::string_view word, const Location& where)>;

// Returns the function that stores the cells of the column with this name. A name that is not in the table of columns
// becomes a foreign column; if it resembles a name of the table, throws InputError.
ReadCell cellReader(Scan& scan, const std::string& name, const Location& at) {
  for (const auto& [axis, member] : {std::pair{"x", &Vec3f::x}, {"y", &Vec3f::y}, {"z", &Vec3f::z}}) {
    if (name != axis) continue;
    return [&scan, axis = axis, member = member](std::string_view word, const Location& where) {
      readNumber(word, scan.position.back().*member, axis, where);
    };
  }
  ReadCell read;
  visitTable(scan, [&](auto key, auto& values) {
    if (key.row.name != name) return;
    read = [&values, key](std::string_view word, const Location& where) {
      readNumber(word, values.emplace_back(), key.row.name, where);
    };
  });
  if (read) return read;
  const std::string meant = nearest(name, scanColumnNames(ColumnSet::all()));
  if (!meant.empty()) throw InputError(at, fmt::format("unknown column '{}' (did you mean '{}'?)", name, meant));
  scan.foreign.push_back({name, std::vector<double>{}});
  return [&scan, index = scan.foreign.size() - 1](std::string_view word, const Location& where) {
    ForeignColumn& column = scan.foreign[index];
    readNumber(word, std::get<std::vector<double>>(column.values).emplace_back(), column.name, where);
  };
}

std::vector<ReadCell> readHeader(std::string_view line, Scan& scan, const Location& where) {
  constexpr std::size_t kMostColumns = 256;
  const auto columnCount = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
  if (columnCount > kMostColumns) throw InputError(where, "the header names too many columns to be a scan's");
  std::vector<std::string> names;
  std::vector<ReadCell> cells;
  for (std::size_t i = 0; i < columnCount; ++i) {
    const std::string name(cut(line, ','));
    const bool word = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    });
    if (!word || std::isdigit(static_cast<unsigned char>(name.front())) != 0) {
      throw InputError(where,
                       fmt::format("'{}' is no name of a column: the first line names them", name.substr(0, 40)));
    }
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      throw InputError(where, fmt::format("column '{}' is named twice", name));
    }
    cells.push_back(cellReader(scan, name, where));
    names.push_back(name);
  }
  for (const char* axis : {"x", "y", "z"}) {
    if (std::find(names.begin(), names.end(), axis) == names.end()) {
      throw InputError(where, fmt::format("there is no column '{}'", axis));
    }
  }
  return cells;
}

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
    Location where{what, 1, 0};
    if (bytes.empty()) throw InputError(where, "the file is empty");
    if (bytes.back() != '\n') {
      where.line = static_cast<int>(std::count(bytes.begin(), bytes.end(), '\n')) + 1;
      throw InputError(where, "the last line has no end: the file is truncated");
    }
    Scan scan;
    const std::vector<ReadCell> columns = readHeader(cutLine(bytes), scan, where);
    while (!bytes.empty()) {
      ++where.line;
      std::string_view line = cutLine(bytes);
      const auto cells = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
      if (cells != columns.size()) {
        throw InputError(where, fmt::format("{} values where the header names {} columns", cells, columns.size()));
      }
      scan.position.emplace_back();
      for (const ReadCell& read : columns) read(cut(line, ','), where);
    }
    return scan;
  }
};

}  // namespace

std::unique_ptr<Format> makeCsv(Fields& options) {
  options.finish();
  return std::make_unique<Csv>();
}

}  // namespace scanmill
