#pragma once

// Parts of the panels that all sessions share. All functions are called within Toolkit::frame().

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

// Draws a panel without title and border at `rect`, filled by `body`. If `scrolls`, the user can scroll to content that
// does not fit; else it is cut off.
void panelAt(const char* name, const PixelRect& rect, bool scrolls, const std::function<void()>& body);
// Draws the row on top of a picture: the title on the left and, dimmed, details on the right.
void titleRow(const PixelRect& rect, const std::string& left, const std::string& right);
// Draws a section of a side panel. A click on its title folds `body` away, unless `still`: in pictures nothing can be
// clicked.
void section(const std::string& title, bool still, const std::function<void()>& body);
// Draws a section that is folded away at first.
void folded(const std::string& title, const std::function<void()>& body);

// A text over the views.
struct PanelLabel {
  double x = 0;  // px, canvas; the text is drawn to the right and above
  double y = 0;
  std::string text;
  bool mark = true;  // with a small ring at (x, y)
};
void drawLabels(const std::vector<PanelLabel>& labels, const PixelRect& within);
// Draws the name of a view among several.
void drawCaption(const PixelRect& view, const std::string& text, bool active);
// Draws the reason why a view shows nothing, large in its middle.
void drawMessage(const PixelRect& view, const std::string& text);

// Draws the entries of a legend and returns what was clicked. `hidden`: one per entry, or empty.
struct LegendUse {
  std::optional<std::size_t> entry;  // the entry that was clicked
  bool all = false;                  // the row for all entries was clicked
};
LegendUse legendRows(const Legend& legend, const std::vector<bool>& hidden, bool clickable, bool still);
// Draws the entries in as many columns as fit, or the scale, for a picture; legendTableHeight() returns px.
void legendTable(const Legend& legend);
int legendTableHeight(const Legend& legend, int width, double letter);
// Draws the scale and, unless `still`, fields for its ends; returns the ends if the user has changed them.
std::optional<ScaleRange> scaleBar(const Legend& legend, bool still);
// Draws the entries or the scale in a section, where the user cannot click or change them.
void legendSection(const Legend& legend, bool still);

void words(const std::string& text);
// Draw a text at a pixel of the canvas, shortened to `width` pixels, and return its width (px); namedColorAt() draws a
// sample of the colour before it.
double wordsAt(double x, double y, double width, const std::string& text, bool dim = false);
double namedColorAt(double x, double y, double width, const std::string& name, const Rgb& color);

// Draws names and values; the row with the name `alarm` is marked as a warning.
void valueRows(const char* id, const NamedValues& rows, const std::string& alarm = "");
void heading(const std::string& text, const Rgb& color);
// Draws a tooltip beside the pointer.
void tip(const std::string& title, const Rgb& color, const NamedValues& rows, const std::string& alarm = "");

// Draws an image of setImage() over a rectangle, cut off at the panel's edge, with a ring about `mark` (px of the
// canvas). True if the pointer is over the image.
bool imageAt(ImageId image, const PixelRect& rect, const std::optional<std::pair<double, double>>& mark = {});

struct FrameBar {
  std::size_t frame = 0;
  std::size_t frames = 0;  // fewer than 2: neither the slider nor `key` is shown
  std::string key, speed, busy;
  bool playing = false;
  std::vector<std::size_t> damaged;  // marked on the slider
};
struct FrameBarUse {
  bool play = false;                 // the play button was pressed
  std::optional<std::size_t> frame;  // the frame that the slider was moved to
};
FrameBarUse frameBar(const PixelRect& rect, const FrameBar& bar);

// Draws messages in the lower left corner of `within`. True if the user has clicked the problems away.
bool messages(const PixelRect& within, const std::vector<std::string>& problems,
              const std::vector<std::string>& notices);

// Draws the list of keys and what they do, over everything. False if the user has closed it.
bool helpWindow(const NamedValues& keys);

}  // namespace scanmill
