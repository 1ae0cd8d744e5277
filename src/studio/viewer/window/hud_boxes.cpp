#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "viewer/font.h"
#include "viewer/window/hud_parts.h"

namespace scanmill {

namespace {

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

}  // namespace scanmill
