#include "viewer/legend.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "viewer/color_map.h"
#include "viewer/font.h"
#include "viewer/scale_ticks.h"

namespace scanmill {

namespace {

// In cells of the text.
constexpr double kMargin = 8;
constexpr double kRowHeight = 14;
constexpr double kSwatch = 8;

double cellFor(int width, int height) {
  return std::clamp(std::min(width / 16.0 * 9.0, static_cast<double>(height)) / 560, 1.0, 6.0);
}

int titleHeight(double cell) {
  return static_cast<int>(std::lround((kCapCells + 9) * cell));
}

// Entries stand in columns of one width, so that the eye runs down them.
struct Table {
  double columnWidth = 1;  // pixels
  int columns = 1;
  int rows = 0;
};

Table tableFor(const Legend& legend, int width, double cell) {
  Table table;
  for (const LegendEntry& e : legend.entries) {
    table.columnWidth = std::max(table.columnWidth, textWidth(e.name, cell) + (kSwatch + 12) * cell);
  }
  const double room = width - 2 * kMargin * cell;
  table.columnWidth = std::min(table.columnWidth, std::max(room, 1.0));
  const int count = static_cast<int>(legend.entries.size());
  table.columns = std::max(static_cast<int>(room / table.columnWidth), 1);
  table.rows = (count + table.columns - 1) / table.columns;
  if (table.rows > 0) table.columns = (count + table.rows - 1) / table.rows;  // no ragged last row
  return table;
}

int legendHeight(const Legend& legend, int width, double cell) {
  const double rows = legend.scale ? 2 : tableFor(legend, width, cell).rows;
  return static_cast<int>(std::lround((rows * kRowHeight + (rows > 0 ? kMargin : 0)) * cell));
}

void drawScale(Image& image, const PictureLayout& layout, const Legend& legend) {
  const double cell = layout.cell;
  const double top = layout.bottom + kMargin * 0.75 * cell;
  double x = kMargin * cell;
  const std::string title = scaleTitle(legend);
  drawText(image, x, top + cell, title, kText, cell);
  x += textWidth(title, cell) + 2 * kMargin * cell;
  const int left = static_cast<int>(x);
  const int barHeight = static_cast<int>(9 * cell);
  const int barWidth =
      std::max(static_cast<int>(std::min(image.width * 0.45, image.width - x - 3 * kMargin * cell)), 2);
  for (int i = 0; i < barWidth; ++i) {
    fillRectangle(image, left + i, static_cast<int>(top), 1, barHeight,
                  viridis(legend.high > legend.low ? static_cast<double>(i) / (barWidth - 1) : 0.5));
  }
  for (const auto& [share, figure] : scaleTicks(legend)) {
    const double place = left + share * (barWidth - 1);
    fillRectangle(image, static_cast<int>(place), static_cast<int>(top) + barHeight,
                  std::max(static_cast<int>(cell), 1), static_cast<int>(3 * cell), kText);
    drawText(image, place - textWidth(figure, cell) / 2, top + barHeight + 5 * cell, figure, kText, cell);
  }
  if (legend.unknown == 0) return;
  const double right = left + barWidth + 2 * kMargin * cell;
  const double textLeft = right + (kSwatch + 4) * cell;
  std::string text = fmt::format("no value: {}", legend.unknown);
  if (!legend.whyUnknown.empty()) text += fmt::format(" ({})", legend.whyUnknown);
  text = fitText(text, image.width - textLeft - kMargin * cell, cell);
  if (text.empty()) return;
  fillRectangle(image, static_cast<int>(right), static_cast<int>(top + 0.5 * cell), static_cast<int>(kSwatch * cell),
                static_cast<int>(kSwatch * cell), kNoValue);
  drawText(image, textLeft, top + cell, text, kText, cell);
}

void drawEntries(Image& image, const PictureLayout& layout, const Legend& legend) {
  const double cell = layout.cell;
  const Table table = tableFor(legend, layout.width, cell);
  const double room = layout.height - layout.bottom - kMargin * cell;
  const int rows = std::clamp(static_cast<int>((room + 1) / (kRowHeight * cell)), 0, table.rows);
  const int places = rows * table.columns;
  const int count = static_cast<int>(legend.entries.size());
  const int shown = count <= places ? count : places - 1;
  for (int i = 0; i < std::min(count, places); ++i) {
    // Down the columns; only a cut table has less rows than it wants.
    const int tableColumn = i / rows;
    const double x = kMargin * cell + tableColumn * table.columnWidth;
    const double y = layout.bottom + kMargin * 0.75 * cell + (i % rows) * kRowHeight * cell;
    if (i >= shown) {
      drawText(image, x, y, fmt::format("+ {} more", count - shown), kText, cell);
      break;
    }
    const LegendEntry& entry = legend.entries[static_cast<std::size_t>(i)];
    fillRectangle(image, static_cast<int>(x), static_cast<int>(y - 0.5 * cell), static_cast<int>(kSwatch * cell),
                  static_cast<int>(kSwatch * cell), entry.color);
    const double textLeft = x + (kSwatch + 4) * cell;
    drawText(image, textLeft, y, fitText(entry.name, table.columnWidth - (kSwatch + 6) * cell, cell), kText, cell);
  }
}

}  // namespace

PictureLayout layoutPicture(int width, int height, const Legend& legend) {
  PictureLayout layout{width, height, 0, height, cellFor(width, height)};
  layout.top = titleHeight(layout.cell);
  layout.bottom = height - std::min(legendHeight(legend, width, layout.cell), height * 2 / 5);
  return layout;
}

PictureLayout layoutAround(int width, int bodyHeight, const Legend& legend) {
  PictureLayout layout{width, 0, 0, 0, cellFor(width, width)};
  layout.top = titleHeight(layout.cell);
  layout.bottom = layout.top + bodyHeight;
  layout.height = layout.bottom + legendHeight(legend, width, layout.cell);
  return layout;
}

void drawTitle(Image& image, const PictureLayout& layout, const std::string& left, const std::string& right) {
  fillRectangle(image, 0, 0, image.width, layout.top, kPanel);
  const double cell = layout.cell;
  const double margin = kMargin * cell;
  const double y = (layout.top - kCapCells * cell) / 2;
  const std::string fitted = fitText(left, image.width - 2 * margin, cell);
  drawText(image, margin, y, fitted, kText, cell);
  const double rightStart = image.width - margin - textWidth(right, cell);
  if (rightStart > 2 * margin + textWidth(fitted, cell)) drawText(image, rightStart, y, right, kNoValue, cell);
}

void drawLegend(Image& image, const PictureLayout& layout, const Legend& legend) {
  fillRectangle(image, 0, layout.bottom, image.width, layout.height - layout.bottom, kPanel);
  if (legend.scale) {
    drawScale(image, layout, legend);
  } else {
    drawEntries(image, layout, legend);
  }
}

void drawNotice(Image& image, const PictureLayout& layout, const std::string& text) {
  const double cell = layout.cell * 2;
  drawText(image, (image.width - textWidth(text, cell)) / 2, (layout.top + layout.bottom - kCapCells * cell) / 2, text,
           kText, cell);
}

}  // namespace scanmill
