#pragma once

// What the panels of all sessions have in common. Everything here is called within Toolkit::frame().

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/coloring.h"
#include "viewer/image.h"
#include "viewer/panels/toolkit.h"

namespace scanmill {

using NamedValues = std::vector<std::pair<std::string, std::string>>;

// A panel that stands at a place and shows neither a title nor an edge; `body` says what it holds. What does not fit
// can be scrolled to, or is cut off.
void panelAt(const char* name, const PixelRect& rect, bool scrolls, const std::function<void()>& body);
// The row on top of a picture: what is shown, and dimly on the right what of it.
void titleRow(const PixelRect& rect, const std::string& left, const std::string& right);
// A part of a side: `body` is folded away by a click on the title, where anything can be clicked.
void section(const std::string& title, bool still, const std::function<void()>& body);
// The same, folded away at first.
void folded(const std::string& title, const std::function<void()>& body);

// Words over the views.
struct PanelLabel {
  double x = 0;  // px, canvas; the label stands right and above
  double y = 0;
  std::string text;
  bool mark = true;  // with a small ring at (x, y)
};
void drawLabels(const std::vector<PanelLabel>& labels, const PixelRect& within);
// A closed line over everything, px of the canvas.
void drawOutline(const std::vector<Vec2d>& corners);
// The name of a view among several.
void drawCaption(const PixelRect& view, const std::string& text, bool active);
// Why a view shows nothing, large in its middle.
void drawMessage(const PixelRect& view, const std::string& text);

// What colours mean. `hidden`: one per entry, or empty.
struct LegendUse {
  std::optional<std::size_t> entry;  // that was pressed
  bool all = false;                  // the row of all was
};
LegendUse legendRows(const Legend& legend, const std::vector<bool>& hidden, bool clickable, bool still);
// The same in as many columns as fit, or the scale, for a picture; px of the whole.
void legendTable(const Legend& legend);
int legendTableHeight(const Legend& legend, int width, double letter);
// The scale, and, where it can be changed, its ends; gives those that were chosen.
std::optional<ScaleRange> scaleBar(const Legend& legend, bool still);
// One or the other in a section, where nothing of it can be pressed or changed.
void legendSection(const Legend& legend, bool still);

void words(const std::string& text);
// At a pixel of the canvas, as much as fits into `width` pixels; returns how wide it is. With a sample of a colour.
double wordsAt(double x, double y, double width, const std::string& text, bool dim = false);
double namedColorAt(double x, double y, double width, const std::string& name, const Rgb& color);

// Names and values; the row `alarm` warns.
void valueRows(const char* id, const NamedValues& rows, const std::string& alarm = "");
void heading(const std::string& text, const Rgb& color);
// Beside the pointer.
void tip(const std::string& title, const Rgb& color, const NamedValues& rows, const std::string& alarm = "");

// An image of setImage() over a rectangle, of which the panel may show a part, with a ring about `mark` (px of the
// canvas). True: the pointer is over it.
bool imageAt(ImageId image, const PixelRect& rect, const std::optional<std::pair<double, double>>& mark = {});

struct FrameBar {
  std::size_t frame = 0;
  std::size_t frames = 0;  // fewer than 2: neither a slider nor a key
  std::string key, speed, busy;
  bool playing = false;
  std::vector<std::size_t> damaged;  // marked on the slider
};
struct FrameBarUse {
  bool play = false;                 // the button was pressed
  std::optional<std::size_t> frame;  // that the slider was moved to
};
FrameBarUse frameBar(const PixelRect& rect, const FrameBar& bar);

// In the lower left corner of `within`. True: the problems were clicked away.
bool messages(const PixelRect& within, const std::vector<std::string>& problems,
              const std::vector<std::string>& notices);

// Keys and what they do, over everything. False: it was closed.
bool helpWindow(const NamedValues& keys);

}  // namespace scanmill
