#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

constexpr double kHelpGap = 14;    // cells, between columns
constexpr double kHelpInset = 10;  // cells
constexpr double kHelpTitle = 18;  // cells
constexpr double kKeyGap = 8;      // cells, between a key and what it does

// Columns of help: keys and what they do, a line each.
struct HelpTable {
  double cell = 1;
  double keyWidth = 0;  // px
  double columnWidth = 0;
  int columns = 1;
  int rows = 0;
  std::vector<std::pair<std::string, std::string>> lines;

  std::size_t places() const { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns); }
  // The last line that may stand first.
  std::size_t lastFirst() const { return lines.size() - std::min(lines.size(), places()); }
};

PixelRect helpBox(const HelpTable& table, const HudState& state) {
  const double inset = 2 * kHelpInset * table.cell;
  const int width = static_cast<int>(
      std::ceil(table.columns * table.columnWidth + (table.columns - 1) * kHelpGap * table.cell + inset));
  const int height = static_cast<int>(
      std::ceil(kHelpTitle * table.cell + inset + linesHeight(static_cast<std::size_t>(table.rows), table.cell)));
  return {(state.width - width) / 2, (state.height - height) / 2, width, height};
}

// What is too long for its column goes on in the next line.
std::vector<std::pair<std::string, std::string>> wrappedRows(const HudState& state, const HelpTable& table) {
  constexpr std::size_t kMostLines = 4;
  const double meaning = table.columnWidth - table.keyWidth - kKeyGap * table.cell;
  std::vector<std::pair<std::string, std::string>> lines;
  for (const auto& [key, does] : state.keys) {
    const auto keys = wrappedText(key, table.keyWidth, table.cell, kMostLines);
    const auto words = wrappedText(does, meaning, table.cell, kMostLines);
    for (std::size_t i = 0; i < std::max(keys.size(), words.size()); ++i) {
      lines.emplace_back(i < keys.size() ? keys[i] : "", i < words.size() ? words[i] : "");
    }
  }
  return lines;
}

// Two columns where they fit, else one, else smaller letters; at last a page of it.
HelpTable helpTable(const HudState& state, double cell) {
  constexpr std::array kScales{1.0, 0.9, 0.8, 0.7, 0.6};
  constexpr double kLeastCell = 0.9;
  const int count = static_cast<int>(state.keys.size());
  HelpTable table;
  for (const double scale : kScales) {
    table.cell = std::max(cell * scale, std::min(cell, kLeastCell));
    table.keyWidth = 0;
    double meaning = 0;
    for (const auto& [key, does] : state.keys) {
      table.keyWidth = std::max(table.keyWidth, textWidth(key, table.cell));
      meaning = std::max(meaning, textWidth(does, table.cell));
    }
    table.columnWidth = table.keyWidth + kKeyGap * table.cell + meaning;
    for (const int columns : {2, 1, 3}) {
      table.columns = columns;
      table.rows = (count + columns - 1) / columns;
      const PixelRect box = helpBox(table, state);
      if (box.width > state.width || box.height > state.height) continue;
      table.lines = state.keys;
      return table;
    }
  }
  constexpr double kKeyShare = 0.3;
  table.columns = 1;
  table.columnWidth = std::max(std::min(table.columnWidth, state.width - 2 * kHelpInset * table.cell), 1.0);
  table.keyWidth = std::min(table.keyWidth, table.columnWidth * kKeyShare);
  table.lines = wrappedRows(state, table);
  const double room = state.height - (2 * kHelpInset + kHelpTitle) * table.cell;
  table.rows = std::min(static_cast<int>(table.lines.size()), static_cast<int>(fittingLines(room, table.cell)));
  return table;
}

}  // namespace

HelpPages helpPages(const HudState& state) {
  const HelpTable table = helpTable(state, frameOf(state).cell);
  return {table.lastFirst(), std::max<std::size_t>(table.places(), 1)};
}

void drawHudHelp(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  const HelpTable table = helpTable(state, frame.cell);
  if (table.rows < 1) return;
  const double cell = table.cell;
  const PixelRect box = helpBox(table, state);
  paint.fill(box, withAlpha(kPanel, kPanelAlpha));  // twice: much text, and nobody looks through it
  paint.panel(box, kEdge, cell);
  regions.push_back({HudPart::Help, box, 0, 0});
  const double left = box.left + kHelpInset * cell;
  const double top = box.top + kHelpInset * cell;
  const std::size_t first = std::min(state.helpFirst, table.lastFirst());
  const std::string close = "h closes";
  double right = box.left + box.width - kHelpInset * cell;
  if (right - textWidth(close, cell) > left + 40 * cell) {
    right -= textWidth(close, cell);
    paint.text(right, top, close, kDimText, cell);
  }
  std::string title = "keys";
  if (table.lastFirst() > 0) {
    title = fmt::format("keys {} to {} of {}: Up, Down, wheel", first + 1, first + table.places(), table.lines.size());
  }
  paint.text(left, top, fittedText(title, right - left - 4 * cell, cell), kDimText, cell);
  const std::size_t last = std::min(table.lines.size(), first + table.places());
  for (std::size_t i = first; i < last; ++i) {
    const auto& [key, does] = table.lines[i];
    const std::size_t place = i - first;
    const auto rows = static_cast<std::size_t>(table.rows);
    const std::size_t tableColumn = place / rows;
    const double x = left + static_cast<double>(tableColumn) * (table.columnWidth + kHelpGap * cell);
    const double y = top + (kHelpTitle + static_cast<double>(place % rows) * kHudRow) * cell;
    paint.text(x, y, fittedText(key, table.keyWidth, cell), kAccent, cell);
    const double meaning = table.keyWidth + kKeyGap * cell;
    paint.text(x + meaning, y, fittedText(does, table.columnWidth - meaning, cell), kText, cell);
  }
}

}  // namespace scanmill
