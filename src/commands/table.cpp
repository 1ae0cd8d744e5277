#include "commands/table.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/terminal.h"

namespace scanmill {

namespace {

// Returns the number of characters, not bytes: UTF-8 continuation bytes have no width.
std::size_t widthOf(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

bool looksNumeric(const std::string& cell) {
  return cell.empty() || cell.find_first_of("0123456789-+<") == 0;
}

}  // namespace

std::string formatTable(const Rows& cells) {
  if (cells.empty()) return {};
  Rows rows = cells;
  for (std::vector<std::string>& row : rows) {
    for (std::string& cell : row) cell = oneLine(cell);
  }
  const std::size_t columns = rows.front().size();
  std::vector<std::size_t> width(columns);
  std::vector<bool> rightAligned(columns, rows.size() > 1);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      width[c] = std::max(width[c], widthOf(rows[r][c]));
      if (r > 0 && !looksNumeric(rows[r][c])) rightAligned[c] = false;
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = " ";
    for (std::size_t c = 0; c < columns; ++c) {
      const std::string gap(width[c] - widthOf(row[c]), ' ');
      line += " " + (rightAligned[c] ? gap + row[c] : row[c] + gap) + " ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string percent(std::uint64_t part, std::uint64_t total) {
  return fmt::format("{:.2f} %", total > 0 ? 100 * static_cast<double>(part) / static_cast<double>(total) : 0.0);
}

}  // namespace scanmill
