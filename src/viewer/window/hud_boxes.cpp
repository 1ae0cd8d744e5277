#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

// Height of so many lines; the last one needs no room below its letters.
double linesHeight(std::size_t lines, double cell) {
  return lines == 0 ? 0 : (static_cast<double>(lines - 1) * kHudRow + kCapCells) * cell;
}

// Lines that fit into a height.
std::size_t fittingLines(double height, double cell) {
  return static_cast<std::size_t>(std::max((height - kCapCells * cell) / (kHudRow * cell) + 1, 0.0));
}

double widest(const std::vector<std::string>& lines, double cell) {
  double width = 0;
  for (const std::string& line : lines) width = std::max(width, textWidth(line, cell));
  return width;
}

// A box of lines whose lower left corner is given; it grows upwards. Returns where it stands.
PixelRect drawLines(HudPaint& paint, const std::vector<std::string>& lines, int left, int bottom, const Rgb& edge,
                    double cell) {
  const int inset = toPixels(kHudMargin, cell);
  const int height = static_cast<int>(std::ceil(linesHeight(lines.size(), cell))) + 2 * inset;
  const PixelRect box{left, bottom - height, static_cast<int>(std::ceil(widest(lines, cell))) + 2 * inset, height};
  paint.panel(box, edge, cell);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    paint.text(box.left + inset, box.top + inset + static_cast<double>(i) * kHudRow * cell, lines[i], kText, cell);
  }
  return box;
}

// The messages, wrapped one by one; what is too much is counted.
std::vector<std::string> messageLines(const std::vector<std::string>& messages, double width, double cell,
                                      std::size_t most) {
  constexpr std::size_t kLinesEach = 4;
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const bool last = i + 1 == messages.size();
    const std::size_t room = most - lines.size() - (last ? 0 : 1);  // a line is kept for the count
    if (room == 0) {
      lines.push_back(fittedText(fmt::format("+ {} more", messages.size() - i), width, cell));
      break;
    }
    for (std::string& line : wrappedText(messages[i], width, cell, std::min(kLinesEach, room))) {
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

// Columns of help: keys and what they do.
struct HelpTable {
  double cell = 1;
  double keyWidth = 0;  // px
  double columnWidth = 0;
  int columns = 1;
  int rows = 0;
};

constexpr double kHelpGap = 14;    // cells, between columns
constexpr double kHelpInset = 10;  // cells
constexpr double kHelpTitle = 18;  // cells

PixelRect helpBox(const HelpTable& table, const HudState& state) {
  const double inset = 2 * kHelpInset * table.cell;
  const int width = static_cast<int>(
      std::ceil(table.columns * table.columnWidth + (table.columns - 1) * kHelpGap * table.cell + inset));
  const int height = static_cast<int>(
      std::ceil(kHelpTitle * table.cell + inset + linesHeight(static_cast<std::size_t>(table.rows), table.cell)));
  return {(state.width - width) / 2, (state.height - height) / 2, width, height};
}

// Two columns where they fit, else one, else smaller letters; at last rows are left out.
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
    table.columnWidth = table.keyWidth + 8 * table.cell + meaning;
    for (const int columns : {2, 1, 3}) {
      table.columns = columns;
      table.rows = (count + columns - 1) / columns;
      const PixelRect box = helpBox(table, state);
      if (box.width <= state.width && box.height <= state.height) return table;
    }
  }
  table.columns = 1;
  table.columnWidth = std::min(table.columnWidth, state.width - 2 * kHelpInset * table.cell);
  table.keyWidth = std::min(table.keyWidth, table.columnWidth * 0.4);
  const double room = state.height - (2 * kHelpInset + kHelpTitle) * table.cell;
  table.rows = std::min(count, static_cast<int>(fittingLines(room, table.cell)));
  return table;
}

}  // namespace

void drawHudMessages(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  constexpr double kWidest = 330;  // cells
  constexpr std::size_t kMostLines = 10;
  const double cell = frame.cell;
  const int margin = toPixels(kHudMargin, cell);
  const PixelRect& body = frame.body;
  const double width = std::min(kWidest * cell, static_cast<double>(body.width - 4 * margin));
  int bottom = body.top + body.height - margin;
  const auto draw = [&](const std::vector<std::string>& messages, double share, const Rgb& edge) -> PixelRect {
    const std::size_t most = std::min(fittingLines(body.height * share - 2 * margin, cell), kMostLines);
    if (messages.empty() || width <= 0 || most == 0) return {};
    const PixelRect box =
        drawLines(paint, messageLines(messages, width, cell, most), body.left + margin, bottom, edge, cell);
    bottom = box.top - margin;
    return box;
  };
  const PixelRect problems = draw(state.problems, 0.6, kAlarm);
  if (!isEmpty(problems)) {
    paint.fill({problems.left, problems.top, std::max(toPixels(2, cell), 2), problems.height}, opaque(kAlarm));
    regions.push_back({HudPart::Problem, problems, 0, 0});
  }
  draw(state.notices, 0.4, kEdge);
}

void drawHudPrompt(HudPaint& paint, const HudState& state, const HudFrame& frame, HudRegions& regions) {
  constexpr double kWidth = 300;  // cells
  constexpr std::size_t kMostHints = 8;
  const double cell = frame.cell;
  const PixelRect& body = frame.body;
  const int inset = toPixels(kHudMargin, cell);
  const int width = std::min(toPixels(kWidth, cell), body.width);
  const double room = width - 2 * inset;
  if (room <= 0) return;
  const double inputHeight = (kCapCells + 8) * cell;
  const double fixed = kHudRow * cell + inputHeight + 2 * inset;
  const std::size_t fitting = fittingLines(body.height * 0.75 - fixed - 6 * cell, cell);
  const std::size_t hints = std::min({state.promptHints.size(), kMostHints, fitting});
  const int height = static_cast<int>(std::ceil(fixed + (hints > 0 ? 6 * cell + linesHeight(hints, cell) : 0)));
  const PixelRect box{body.left + (body.width - width) / 2, body.top + std::max((body.height - height) / 4, 0), width,
                      height};
  paint.panel(box, kAccent, cell);
  regions.push_back({HudPart::Panel, box, 0, 0});
  const double left = box.left + inset;
  double y = box.top + inset;
  paint.text(left, y, fittedText(state.promptCaption, room, cell), kDimText, cell);
  y += kHudRow * cell;
  const PixelRect input{static_cast<int>(left), static_cast<int>(y), static_cast<int>(room),
                        static_cast<int>(inputHeight)};
  paint.fill(input, opaque(kBackground));
  const std::string typed = fittedTail(*state.prompt, room - 12 * cell, cell);
  paint.text(left + 4 * cell, y + 4 * cell, typed, kText, cell);
  paint.fill({static_cast<int>(left + 6 * cell + (typed.empty() ? -2 * cell : textWidth(typed, cell))),
              static_cast<int>(y + 3 * cell), std::max(toPixels(1, cell), 1), toPixels(kCapCells + 2, cell)},
             opaque(kAccent));
  y += inputHeight + 6 * cell;
  for (std::size_t i = 0; i < hints; ++i) {
    paint.text(left + 4 * cell, y + static_cast<double>(i) * kHudRow * cell,
               fittedText(state.promptHints[i], room - 8 * cell, cell), kDimText, cell);
  }
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
  paint.text(left, top, fittedText("keys", table.columnWidth, cell), kDimText, cell);
  const std::string close = "h closes";
  const double closeLeft = box.left + box.width - kHelpInset * cell - textWidth(close, cell);
  if (closeLeft > left + 40 * cell) paint.text(closeLeft, top, close, kDimText, cell);
  const auto places = static_cast<std::size_t>(table.rows) * static_cast<std::size_t>(table.columns);
  for (std::size_t i = 0; i < std::min(state.keys.size(), places); ++i) {
    const auto& [key, does] = state.keys[i];
    const bool cut = i + 1 == places && places < state.keys.size();
    const std::size_t column = i / static_cast<std::size_t>(table.rows);
    const double x = left + static_cast<double>(column) * (table.columnWidth + kHelpGap * cell);
    const double y =
        top + (kHelpTitle + static_cast<double>(i % static_cast<std::size_t>(table.rows)) * kHudRow) * cell;
    if (cut) {
      const std::string more = fmt::format("+ {} more", state.keys.size() - i);
      paint.text(x, y, fittedText(more, table.columnWidth, cell), kDimText, cell);
      break;
    }
    paint.text(x, y, fittedText(key, table.keyWidth, cell), kAccent, cell);
    const double meaning = table.keyWidth + 8 * cell;
    paint.text(x + meaning, y, fittedText(does, table.columnWidth - meaning, cell), kText, cell);
  }
}

void drawHudTip(HudPaint& paint, const HudTip& tip, const HudFrame& frame) {
  constexpr double kAway = 10;          // cells, from the pointer
  constexpr double kWidestValue = 170;  // cells
  constexpr double kSwatch = 8;         // cells
  const double cell = frame.cell;
  const int inset = toPixels(kHudMargin, cell);
  const double roomWidth = paint.width() - 2.0 * inset;
  const double roomHeight = paint.height() - 2.0 * inset;
  const std::size_t lines = std::min(tip.rows.size() + 1, fittingLines(roomHeight, cell));
  if (lines == 0 || roomWidth < kSwatch * cell) return;
  double names = 0;
  double values = 0;
  for (const auto& [name, value] : tip.rows) {
    names = std::max(names, textWidth(name, cell));
    values = std::max(values, textWidth(value, cell));
  }
  names = std::min(names, roomWidth * 0.4);
  const double valueLeft = tip.rows.empty() ? 0 : names + 8 * cell;
  const double headingLeft = (kSwatch + 4) * cell;
  const double width = std::min(std::max(headingLeft + std::min(textWidth(tip.heading, cell), kWidestValue * cell),
                                         valueLeft + std::min(values, kWidestValue * cell)),
                                roomWidth);
  const int boxWidth = std::min(static_cast<int>(std::ceil(width)) + 2 * inset, paint.width());
  const int boxHeight = std::min(static_cast<int>(std::ceil(linesHeight(lines, cell))) + 2 * inset, paint.height());
  // To the right and below; on the other side of the pointer where that is outside.
  const int away = toPixels(kAway, cell);
  const auto placed = [away](int at, int size, int whole) {
    const int pointer = std::clamp(at, 0, whole);
    if (pointer + away + size <= whole) return pointer + away;
    return std::clamp(pointer - away - size, 0, whole - size);
  };
  const PixelRect box{placed(tip.x, boxWidth, paint.width()), placed(tip.y, boxHeight, paint.height()), boxWidth,
                      boxHeight};
  paint.panel(box, kEdge, cell);
  const double left = box.left + inset;
  const double top = box.top + inset;
  const int size = toPixels(kSwatch, cell);
  paint.fill({static_cast<int>(left), static_cast<int>(std::lround(top - 0.5 * cell)), size, size}, opaque(tip.color));
  paint.text(left + headingLeft, top, fittedText(tip.heading, width - headingLeft, cell), kText, cell);
  for (std::size_t i = 1; i < lines; ++i) {
    const double y = top + static_cast<double>(i) * kHudRow * cell;
    if (i + 1 == lines && lines < tip.rows.size() + 1) {
      paint.text(left, y, fittedText(fmt::format("+ {} more", tip.rows.size() + 1 - i), width, cell), kDimText, cell);
      break;
    }
    const auto& [name, value] = tip.rows[i - 1];
    paint.text(left, y, fittedText(name, names, cell), kDimText, cell);
    paint.text(left + valueLeft, y, fittedText(value, width - valueLeft, cell), kText, cell);
  }
}

}  // namespace scanmill
