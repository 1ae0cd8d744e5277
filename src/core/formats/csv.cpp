// csv: comma-separated values. The header line names exactly the columns of the lines below it, in their order.
//
//   x,y,z,intensity,label
//   1.5,-2.25,0.125,37,4
//
// Numbers have the shortest digits that read back to the same bits, lines end with '\n', the misses of an organised
// scan are "nan". The text says nothing of the sensor: decode() gives one row per line, and rings and columns unknown.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "formats/columns.h"
#include "formats/makers.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

constexpr std::array<const char*, 11> kNames{"x",    "y",      "z",    "intensity",  "label",    "instance",
                                             "ring", "column", "time", "range_true", "incidence"};

// Cuts the text up to the next `separator`, which is removed; the rest of the text where there is none.
std::string_view cut(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view piece = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return piece;
}

// Indices into kNames.
std::vector<std::size_t> readHeader(std::string_view line, const Location& where) {
  const std::vector<std::string> known(kNames.begin(), kNames.end());
  std::vector<std::size_t> columns;
  const auto columnCount = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
  if (columnCount > kNames.size()) throw InputError(where, "the header names too many columns to be a scan's");
  for (std::size_t i = 0; i < columnCount; ++i) {
    const std::string_view name = cut(line, ',');
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (found == kNames.end()) {
      throw InputError(where, fmt::format("unknown column '{}'{}", name.substr(0, 40), suggestion(name, known)));
    }
    const auto index = static_cast<std::size_t>(found - kNames.begin());
    if (std::find(columns.begin(), columns.end(), index) != columns.end()) {
      throw InputError(where, fmt::format("column '{}' is named twice", name));
    }
    columns.push_back(index);
  }
  for (const std::size_t axis : {0u, 1u, 2u}) {
    if (std::find(columns.begin(), columns.end(), axis) == columns.end()) {
      throw InputError(where, fmt::format("there is no column '{}'", kNames[axis]));
    }
  }
  return columns;
}

template <class T>
void readInto(std::vector<T>& column, std::string_view word, std::size_t index, const Location& where) {
  readNumber(word, column.emplace_back(), kNames[index], where);
}

void readCell(Scan& scan, std::size_t index, std::string_view word, const Location& where) {
  switch (index) {
    case 0:
      return readNumber(word, scan.position.back().x, "x", where);
    case 1:
      return readNumber(word, scan.position.back().y, "y", where);
    case 2:
      return readNumber(word, scan.position.back().z, "z", where);
    case 3:
      return readInto(scan.intensity, word, index, where);
    case 4:
      return readInto(scan.label, word, index, where);
    case 5:
      return readInto(scan.instance, word, index, where);
    case 6:
      return readInto(scan.ring, word, index, where);
    case 7:
      return readInto(scan.column, word, index, where);
    case 8:
      return readInto(scan.time, word, index, where);
    case 9:
      return readInto(scan.rangeTrue, word, index, where);
    default:
      return readInto(scan.incidence, word, index, where);
  }
}

class Csv : public Format {
 public:
  std::string_view suffix() const override { return "csv"; }
  double maxError() const override { return 0; }
  bool keepsMisses() const override { return true; }

  double mostBytes(const ScanOutline& outline) const override {
    return static_cast<double>(fmt::format("{}\n", fmt::join(outline.names, ",")).size()) +
           static_cast<double>(outline.points) * static_cast<double>(longestRow(outline.names));
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
    const std::vector<std::size_t> columns = readHeader(cut(bytes, '\n'), where);
    Scan scan;
    while (!bytes.empty()) {
      ++where.line;
      std::string_view line = cut(bytes, '\n');
      const auto cells = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
      if (cells != columns.size()) {
        throw InputError(where, fmt::format("{} values where the header names {} columns", cells, columns.size()));
      }
      scan.position.emplace_back();
      for (const std::size_t column : columns) readCell(scan, column, cut(line, ','), where);
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
