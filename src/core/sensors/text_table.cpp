#include "sensors/text_table.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/file.h"
#include "base/text_scan.h"
#include "config/text.h"

namespace scanmill {
namespace {

struct TimeUnit {
  std::string_view name;  // name of the column of times
  double seconds;         // length of the unit (s)
};
constexpr TimeUnit kTimes[] = {{"time", 1}, {"time_s", 1}, {"time_ms", 1e-3}, {"time_us", 1e-6}, {"time_ns", 1e-9}};

// Returns the column's name for a heading, as described at TextTable: "Time [ms]" is time_ms.
std::string columnName(std::string_view heading) {
  static const std::map<std::string, std::string> kUnits{
      {"s", "_s"},   {"sec", "_s"}, {"ms", "_ms"}, {"us", "_us"},   {"\u00b5s", "_us"}, {"\u03bcs", "_us"},
      {"ns", "_ns"}, {"m", ""},     {"", ""},      {"deg", "_deg"}, {"\u00b0", "_deg"}, {"rad", "_rad"}};
  std::string name = lowerCase(heading), unit;
  const std::size_t bracket = name.find_first_of("[(");
  const bool inBrackets = bracket != std::string::npos && name.ends_with(name[bracket] == '[' ? ']' : ')');
  if (const std::size_t end = inBrackets ? bracket : name.rfind('/'); end != std::string::npos) {
    unit = name.substr(end + 1, name.size() - end - (inBrackets ? 2 : 1));
    const auto suffix = kUnits.find(unit);
    unit = suffix == kUnits.end() ? "_" + unit : suffix->second;
    name.resize(end);
  }
  name += unit;
  std::erase_if(name, [](char c) { return !('a' <= c && c <= 'z') && !('0' <= c && c <= '9') && c != '_'; });
  return name;
}

// True if a line is a hexadecimal checksum, with which some of Hesai's files end.
bool isChecksum(std::string_view text) {
  return text.size() >= 32 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
}

}  // namespace

std::vector<TextLine> linesOf(std::string_view bytes, const std::filesystem::path& file) {
  std::vector<TextLine> lines;
  int number = 0;
  for (std::string_view rest = textOfFile(bytes); !rest.empty();) {
    const std::string_view text = takeLine(rest);
    ++number;
    if (!text.empty() && text.front() != '#') lines.push_back({{file.string(), number}, text});
  }
  if (lines.empty()) throw InputError({file.string()}, "is empty");
  return lines;
}

double numberOf(std::string_view text, const Location& where) {
  double number = 0;
  if (parseNumber(text, number) && std::isfinite(number)) return number;
  throw InputError(where, "{} is not a number{}", quotedForMessage(text), numberAdvice(text));
}

TextTable::TextTable(const std::filesystem::path& file) : bytes_(readFile(file)) {
  // If the file begins with a comment and the next line with a number, the comment names the columns: remove its #.
  if (const std::size_t start = bytes_.find_first_not_of("\xEF\xBB\xBF");
      start < bytes_.size() && bytes_[start] == '#') {
    const std::string_view firstLine = linesOf(bytes_, file).front().text;
    if (firstLine.find_first_of("+-.0123456789") == 0) bytes_[start] = ' ';
  }
  const std::vector<TextLine> lines = linesOf(bytes_, file);
  head_ = lines.front().where;
  std::vector<std::string_view> cells;
  for (const TextLine& line : lines) {
    const bool semicolons = line.text.find(';') != line.text.npos;
    splitCells(line.text, semicolons ? ';' : line.text.find(',') != line.text.npos ? ',' : ' ', cells);
    if (names_.empty()) {
      for (const std::string_view cell : cells) names_.push_back(columnName(cell));
      while (!names_.empty() && names_.back().empty()) names_.pop_back();  // come from separators at the line's end
      continue;
    }
    if (&line == &lines.back() && isChecksum(cells.front())) continue;
    while (cells.size() > names_.size() && cells.back().empty()) cells.pop_back();
    if (cells.size() != names_.size()) {
      throw InputError(line.where, "has {} cells, but the first line has {}", cells.size(), names_.size());
    }
    rows_.push_back({line.where, cells});
  }
  if (rows_.empty()) throw InputError(head_, "the table has no line after the column names");
}

std::optional<std::size_t> TextTable::find(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end()) return std::nullopt;
  if (std::find(found + 1, names_.end(), name) != names_.end()) {
    throw InputError(head_, "the column '{}' is listed twice", name);
  }
  return static_cast<std::size_t>(found - names_.begin());
}

void TextTable::rename(std::string_view oldName, const char* newName) {
  const auto name = std::ranges::find(names_, oldName);
  if (name != names_.end()) *name = newName;
}

void TextTable::require(std::string_view name) const {
  if (!has(name)) throw InputError(head_, "the table has no column {}", name);
}

void TextTable::expectOnly(const std::vector<std::string>& columns) const {
  for (const std::string& name : names_) {
    if (std::ranges::find(columns, name) != columns.end()) continue;
    throw InputError(head_, "the column '{}' is unknown{}", name, suggestion(name, columns));
  }
}

double TextTable::number(std::size_t row, std::string_view name, Range range) const {
  const std::optional<std::size_t> column = find(name);
  if (!column) return 0;
  const double number = numberOf(rows_[row].cells[*column], rows_[row].where);
  if (number >= range.low && number <= range.high) return number;
  throw InputError(rows_[row].where, "{} is {:g}, but must be from {:g} to {:g}", name, number, range.low, range.high);
}

double TextTable::time(std::size_t row, Range range) const {
  const auto* const unit = std::ranges::find(kTimes, timeName(), &TimeUnit::name);
  if (unit == std::end(kTimes)) return 0;
  return number(row, unit->name, {range.low / unit->seconds, range.high / unit->seconds}) * unit->seconds;
}

std::string_view TextTable::timeName() const {
  std::string_view name;
  for (const TimeUnit& unit : kTimes) {
    if (!has(unit.name)) continue;
    if (!name.empty()) {
      throw InputError(head_, "the table has two columns of time: leave out {} or {}", name, unit.name);
    }
    name = unit.name;
  }
  return name;
}

}  // namespace scanmill
