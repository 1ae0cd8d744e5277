#include "sensors/text_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "config/text.h"

namespace scanmill {

std::vector<TextLine> linesOf(const std::string& bytes, const std::filesystem::path& file) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    throw InputError({file.string()}, "is UTF-16 text: save it as UTF-8, for example with 'iconv -f UTF-16 -t UTF-8'");
  }
  std::vector<TextLine> lines;
  int number = 0;
  for (std::size_t at = bytes.starts_with(kMark) ? kMark.size() : 0; at < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
    std::string_view text(bytes.data() + at, end - at);
    at = end + 1;
    ++number;
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    if (!text.empty() && text.front() != '#') lines.push_back({{file.string(), number}, text});
  }
  if (lines.empty()) throw InputError({file.string()}, "is empty");
  return lines;
}

std::vector<std::string_view> cellsOf(std::string_view text) {
  const bool semicolons = text.find(';') != std::string_view::npos;
  const bool table = semicolons || text.find(',') != std::string_view::npos;
  const std::string_view separators = semicolons ? ";" : table ? "," : " \t";
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= text.size();) {
    // Separators between quotes belong to the cell.
    const std::size_t begin = std::min(text.find_first_not_of(" \t", at), text.size());
    const std::size_t close = begin < text.size() && text[begin] == '"' ? text.find('"', begin + 1) : text.npos;
    const std::size_t end = std::min(text.find_first_of(separators, close == text.npos ? at : close), text.size());
    std::string_view cell = text.substr(at, end - at);
    at = end + 1;
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
    if (table || !cell.empty()) cells.push_back(cell);
  }
  return cells;
}

ColumnName columnName(std::string_view cell) {
  static const std::map<std::string, std::string> kUnits{
      {"s", "s"},   {"sec", "s"}, {"ms", "ms"},   {"us", "us"},      {"\u00b5s", "us"}, {"\u03bcs", "us"},
      {"ns", "ns"}, {"m", "m"},   {"deg", "deg"}, {"\u00b0", "deg"}, {"rad", "rad"}};
  ColumnName column{lowerCase(cell), {}};
  std::string& name = column.name;
  const std::size_t bracket = name.find_first_of("[(");
  const bool inBrackets = bracket != std::string::npos && name.ends_with(name[bracket] == '[' ? ']' : ')');
  const std::size_t sign = inBrackets ? bracket : name.rfind('/');
  if (sign == std::string::npos) return column;
  const std::string stated = name.substr(sign + 1, name.size() - sign - (inBrackets ? 2 : 1));
  const auto known = kUnits.find(stated);
  if (!inBrackets && known == kUnits.end()) return column;
  column.unit = known == kUnits.end() ? stated : known->second;
  name.resize(sign);
  name.erase(name.find_last_not_of(' ') + 1);
  return column;
}

double numberOf(std::string_view text, const Location& where) {
  double number = 0;
  const std::string_view plain = text.substr(text.starts_with('+') && !text.starts_with("+-") ? 1 : 0);
  const auto [end, error] = std::from_chars(plain.data(), plain.data() + plain.size(), number);
  if (error != std::errc() || end != plain.data() + plain.size() || !std::isfinite(number)) {
    throw InputError(where, fmt::format("{} is not a number{}", quotedForMessage(text), numberAdvice(text)));
  }
  return number;
}

}  // namespace scanmill
