#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/grouped.h"
#include "viewer/font.h"
#include "viewer/scale_ticks.h"
#include "viewer/window/hud_parts.h"
#include "viewer/window/picked_rows.h"

namespace scanmill {

namespace {

// In cells of the text.
constexpr double kSwatch = 8;
constexpr double kColumnGap = 10;
constexpr double kLongestName = 120;
constexpr double kLongestOfFew = 240;  // names of short lists are sentences
constexpr std::size_t kFew = 6;
constexpr double kLeastColumn = 24;  // narrower ones are not worth reading
constexpr double kLeastCell = 1;     // px: smaller letters cannot be read
constexpr double kBarWidth = 9;
constexpr double kTickLength = 3;

struct Row {
  enum class Look { Shown, Absent, Partly, Hidden };
  std::string name;
  std::string count;
  Rgb color{};
  Look look = Look::Shown;
  std::optional<HudPart> part;
  std::size_t entry = 0;
};

// A title, and rows in columns of one width, so that the eye runs down them.
struct Table {
  double cell = 1;
  double columnWidth = 1;  // px
  int columns = 1;
  int rows = 1;
};

// What a panel may take of its pane.
struct Room {
  int width = 0;
  int height = 0;
};

bool isHidden(const HudPane& pane, std::size_t entry) {
  return entry < pane.hidden.size() && pane.hidden[entry];
}

std::vector<Row> rowsOf(const HudPane& pane) {
  const std::vector<LegendEntry>& entries = pane.legend.entries;
  std::uint64_t points = 0;
  std::size_t hidden = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    points += entries[i].points;
    hidden += isHidden(pane, i) ? 1 : 0;
  }
  const auto count = [&](std::uint64_t n) { return points > 0 ? grouped(n) : std::string(); };
  std::vector<Row> rows;
  if (pane.clickable && !entries.empty()) {
    const Row::Look look = hidden == 0               ? Row::Look::Shown
                           : hidden < entries.size() ? Row::Look::Partly
                                                     : Row::Look::Hidden;
    rows.push_back({"all", count(points), kText, look, HudPart::LegendAll, 0});
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    Row& row = rows.emplace_back(Row{entries[i].name, count(entries[i].points), entries[i].color, {}, {}, i});
    const bool absent = points > 0 && entries[i].points == 0;  // of this frame
    row.look = isHidden(pane, i) ? Row::Look::Hidden : absent ? Row::Look::Absent : Row::Look::Shown;
    if (pane.clickable) row.part = HudPart::Legend;
  }
  return rows;
}

double widestCount(const std::vector<Row>& rows, double cell) {
  double widest = 0;
  for (const Row& row : rows) widest = std::max(widest, textWidth(row.count, cell));
  return widest > 0 ? widest + 8 * cell : 0;
}

double columnWidth(const std::vector<Row>& rows, const std::string& title, double cell) {
  const double longest = (rows.size() <= kFew ? kLongestOfFew : kLongestName) * cell;
  double name = 0;
  for (const Row& row : rows) name = std::max(name, textWidth(row.name, cell));
  const double entries = (kSwatch + 4) * cell + std::min(name, longest) + widestCount(rows, cell);
  return std::max(entries, std::min(textWidth(title, cell), longest));
}

double titleRoom(const std::string& title, double cell) {
  return title.empty() ? 0 : kHudRow * cell;
}

int panelWidth(const Table& table) {
  return static_cast<int>(
      std::ceil(table.columns * table.columnWidth + ((table.columns - 1) * kColumnGap + 2 * kHudMargin) * table.cell));
}

// The last row needs no room below its letters.
int panelHeight(const Table& table, const std::string& title) {
  const double rows = (table.rows * kHudRow - (kHudRow - kSwatch) + 2 * kHudMargin) * table.cell;
  return static_cast<int>(std::ceil(rows + titleRoom(title, table.cell)));
}

// The largest letters and the fewest columns in which all rows fit.
std::optional<Table> wholeTable(const std::vector<Row>& rows, const std::string& title, const Room& room, double cell) {
  constexpr int kMostColumns = 4;
  constexpr double kPaneShare = 0.5;
  const int count = static_cast<int>(rows.size());
  for (const double scale : {1.0, 0.85, 0.7}) {
    const double smaller = std::max(cell * scale, std::min(cell, kLeastCell));
    Table table{smaller, columnWidth(rows, title, smaller), 1, count};
    for (; table.columns <= kMostColumns; ++table.columns) {
      table.rows = (count + table.columns - 1) / table.columns;
      if (panelWidth(table) > (table.columns == 1 ? room.width : room.width * kPaneShare)) break;
      if (panelHeight(table, title) <= room.height) return table;
    }
  }
  return {};
}

// Small letters, and as many rows as fit. None: none does.
std::optional<Table> cutTable(const std::vector<Row>& rows, const std::string& title, const Room& room, double cell) {
  Table table;
  table.cell = std::max(cell * 0.7, std::min(cell, kLeastCell));
  table.columnWidth = std::min(columnWidth(rows, title, table.cell), room.width - 2 * kHudMargin * table.cell);
  table.rows = static_cast<int>((room.height - panelHeight({table.cell, 1, 1, 0}, title)) / (kHudRow * table.cell));
  if (table.rows < 1 || table.columnWidth < kLeastColumn * table.cell) return {};
  table.rows = std::min(table.rows, static_cast<int>(rows.size()));
  const double gap = kColumnGap * table.cell;
  table.columns = std::max(static_cast<int>((room.width / 2.0 + gap) / (table.columnWidth + gap)), 1);
  return table;
}

// Counts go before rows do.
std::optional<Table> tableFor(std::vector<Row>& rows, const std::string& title, const Room& room, double cell) {
  if (std::optional<Table> whole = wholeTable(rows, title, room, cell)) return whole;
  for (Row& row : rows) row.count.clear();
  if (std::optional<Table> whole = wholeTable(rows, title, room, cell)) return whole;
  return cutTable(rows, title, room, cell);
}

// In the pane's right upper corner.
PixelRect panelAt(const PixelRect& pane, int width, int height, double cell) {
  const int margin = toPixels(kHudMargin, cell);
  return {pane.left + pane.width - margin - width, pane.top + margin, width, height};
}

void drawSwatch(HudPaint& paint, const PixelRect& swatch, const Row& row, double cell) {
  const int line = std::max(toPixels(1, cell), 1);
  switch (row.look) {
    case Row::Look::Shown:
    case Row::Look::Absent:
      paint.fill(swatch, opaque(row.color));
      break;
    case Row::Look::Partly:
      paint.frame(swatch, opaque(row.color), line);
      paint.fill({swatch.left + 2 * line, swatch.top + 2 * line, swatch.width - 4 * line, swatch.height - 4 * line},
                 opaque(row.color));
      break;
    case Row::Look::Hidden:
      paint.frame(swatch, opaque(kNoValue), line);
      break;
  }
}

void drawEntries(HudPaint& paint, const HudPane& pane, std::size_t number, const PixelRect& rect, const Room& room,
                 double frameCell, HudRegions& regions) {
  std::vector<Row> rows = rowsOf(pane);
  const std::string& title = pane.legend.title;
  const std::optional<Table> table = tableFor(rows, title, room, frameCell);
  if (!table) return;
  const double cell = table->cell;
  const PixelRect panel = panelAt(rect, panelWidth(*table), panelHeight(*table, title), frameCell);
  paint.panel(panel, kEdge, cell);
  regions.push_back({HudPart::Panel, panel, number, 0});
  const double left = panel.left + kHudMargin * cell;
  const double top = panel.top + kHudMargin * cell;
  if (!title.empty()) paint.text(left, top, fittedText(title, table->columnWidth, cell), kDimText, cell);
  const int count = static_cast<int>(rows.size());
  const int places = table->rows * table->columns;
  const int shown = count <= places ? count : places - 1;
  const double countWidth = widestCount(rows, cell);
  for (int i = 0; i < std::min(count, places); ++i) {
    const int column = i / table->rows;
    const double x = left + column * (table->columnWidth + kColumnGap * cell);
    const double y = top + titleRoom(title, cell) + (i % table->rows) * kHudRow * cell;
    if (i >= shown) {
      paint.text(x, y, fittedText(fmt::format("+ {} more", count - shown), table->columnWidth, cell), kDimText, cell);
      break;
    }
    const Row& row = rows[static_cast<std::size_t>(i)];
    const Rgb color = row.look == Row::Look::Hidden ? kNoValue : row.look == Row::Look::Absent ? kDimText : kText;
    const int size = toPixels(kSwatch, cell);
    drawSwatch(paint, {static_cast<int>(x), static_cast<int>(std::lround(y - 0.5 * cell)), size, size}, row, cell);
    const double nameLeft = (kSwatch + 4) * cell;
    const double nameRoom = table->columnWidth - nameLeft;
    const bool counted = nameRoom - countWidth > std::min(kLeastColumn * cell, textWidth(row.name, cell));
    paint.text(x + nameLeft, y, fittedText(row.name, counted ? nameRoom - countWidth : nameRoom, cell), color, cell);
    if (counted) {
      paint.text(x + table->columnWidth - textWidth(row.count, cell), y, row.count,
                 row.look == Row::Look::Hidden ? kNoValue : kDimText, cell);
    }
    if (row.part) {
      const double slack = (kHudRow - kSwatch) / 2 * cell;
      regions.push_back({*row.part,
                         {static_cast<int>(x - 3 * cell), static_cast<int>(y - 0.5 * cell - slack),
                          static_cast<int>(table->columnWidth + 6 * cell), toPixels(kHudRow, cell)},
                         number,
                         row.entry});
    }
  }
}

// Below a scale: how many points have no value, and why.
std::vector<std::string> unknownLines(const Legend& legend, double width, double cell) {
  constexpr std::size_t kMostLines = 3;
  if (legend.unknown == 0) return {};
  std::string text = fmt::format("no value: {}", grouped(legend.unknown));
  if (!legend.whyUnknown.empty()) text += fmt::format("\n{}", legend.whyUnknown);
  return wrappedText(text, width, cell, kMostLines);
}

Rgb scaleColor(const Legend& legend, int at, int length) {
  return viridis(legend.high > legend.low && length > 1 ? static_cast<double>(at) / (length - 1) : 0.5);
}

// Upright where there is room, else lying with its ends' figures below.
void drawScale(HudPaint& paint, const Legend& legend, std::size_t number, const PixelRect& rect, const Room& room,
               double cell, HudRegions& regions) {
  constexpr double kLongest = 130, kShortest = 50, kTitleWidth = 90;  // cells
  constexpr std::size_t kTitleLines = 4;
  const std::vector<ScaleTick> ticks = scaleTicks(legend);
  double figures = 0;
  for (const ScaleTick& tick : ticks) figures = std::max(figures, textWidth(tick.figure, cell));
  const int inset = toPixels(kHudMargin, cell);
  const double titleWidth = std::min(kTitleWidth * cell, static_cast<double>(room.width - 2 * inset));
  const std::vector<std::string> title = wrappedText(scaleTitle(legend), titleWidth, cell, kTitleLines);
  const double unknownLeft = (kSwatch + 4) * cell;
  const std::vector<std::string> unknown = unknownLines(legend, titleWidth - unknownLeft, cell);
  double widest = 0;
  for (const std::string& line : title) widest = std::max(widest, textWidth(line, cell));
  for (const std::string& line : unknown) widest = std::max(widest, unknownLeft + textWidth(line, cell));
  const int unknownHeight = toPixels(static_cast<double>(unknown.size()) * kHudRow, cell);
  const int titleHeight = toPixels(static_cast<double>(title.size()) * kHudRow, cell);

  const int thick = toPixels(kBarWidth, cell);
  const double roomHeight = room.height - titleHeight - unknownHeight - 2 * inset;
  const bool upright = roomHeight >= kShortest * cell;
  const double beside = (kBarWidth + kTickLength + 3) * cell + figures;
  const double lying = std::max(2 * figures + 8 * cell, kShortest * cell);
  const int width = static_cast<int>(std::ceil(std::max(widest, upright ? beside : lying))) + 2 * inset;
  const int length = upright ? toPixels(std::min(kLongest, roomHeight / cell), cell) : std::max(width - 2 * inset, 1);
  const int below = upright ? length : thick + toPixels(kTickLength + 9, cell);
  const int height = titleHeight + 2 * inset + below + unknownHeight;
  if (width > room.width || height > room.height) return;
  const PixelRect panel = panelAt(rect, width, height, cell);
  paint.panel(panel, kEdge, cell);
  regions.push_back({HudPart::Panel, panel, number, 0});
  const int left = panel.left + inset;
  const int top = panel.top + inset + titleHeight;
  for (std::size_t i = 0; i < title.size(); ++i) {
    paint.text(left, panel.top + inset + static_cast<double>(i) * kHudRow * cell, title[i], kDimText, cell);
  }
  for (int i = 0; i < length; ++i) {
    const Rgba color = opaque(scaleColor(legend, i, length));
    paint.fill(upright ? PixelRect{left, top + length - 1 - i, thick, 1} : PixelRect{left + i, top, 1, thick}, color);
  }
  const int line = std::max(toPixels(1, cell), 1);
  const int tickLength = toPixels(kTickLength, cell);
  const double first = top + below + (kHudRow - kCapCells) * cell;
  if (!unknown.empty()) {
    const int size = toPixels(kSwatch, cell);
    paint.fill({left, static_cast<int>(std::lround(first - 0.5 * cell)), size, size}, opaque(kNoValue));
  }
  for (std::size_t i = 0; i < unknown.size(); ++i) {
    paint.text(left + unknownLeft, first + static_cast<double>(i) * kHudRow * cell, unknown[i],
               i == 0 ? kText : kDimText, cell);
  }
  for (const ScaleTick& tick : ticks) {
    const int along = static_cast<int>(std::lround(tick.share * (length - line)));
    if (upright) {
      const int y = top + length - line - along;
      paint.fill({left + thick, y, tickLength, line}, opaque(kDimText));
      const double letters = std::clamp(y - 3.5 * cell, static_cast<double>(top), top + length - 7 * cell);
      paint.text(left + thick + tickLength + 3 * cell, letters, tick.figure, kText, cell);
      continue;
    }
    paint.fill({left + along, top + thick, line, tickLength}, opaque(kDimText));
    const bool end = &tick == &ticks.front() || &tick == &ticks.back();  // there is room for two
    const double own = textWidth(tick.figure, cell);
    if (end) paint.text(left + tick.share * (length - own), top + thick + 5 * cell, tick.figure, kText, cell);
  }
}

}  // namespace

void drawHudLegend(HudPaint& paint, const HudPane& pane, std::size_t number, const HudFrame& frame,
                   HudRegions& regions) {
  const PixelRect& rect = frame.panes[number];
  const int margin = 2 * toPixels(kHudMargin, frame.cell);
  const Room room{rect.width - margin, rect.height - margin};
  if (pane.legend.scale) {
    drawScale(paint, pane.legend, number, rect, room, frame.cell, regions);
  } else if (!pane.legend.entries.empty()) {
    drawEntries(paint, pane, number, rect, room, frame.cell, regions);
  }
}

}  // namespace scanmill
