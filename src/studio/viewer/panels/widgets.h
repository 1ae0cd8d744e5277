#pragma once

// Parts of panels that are used in all sessions of the viewer. All functions must be called within ImGuiLayer::frame().

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/coloring.h"
#include "viewer/panels/imgui_layer.h"

namespace scanmill {

using NamedValues = std::vector<std::pair<std::string, std::string>>;

// The use of a panel. In an interactive panel, the user can scroll, and open or close sections.
enum class PanelUse { Picture, Interactive };

// Draws a panel without title and border in `rect`. `body` draws the contents. In an interactive panel the user can
// scroll to contents that do not fit; in a picture they are clipped.
void panelAt(const char* name, const PixelRect& rect, PanelUse use, const std::function<void()>& body);
// Draws the row at the top of a picture: the title on the left, and details in a dim colour on the right.
void titleRow(const PixelRect& rect, const std::string& left, const std::string& right);
// Draws a section of a side panel. In an interactive panel, a click on its title hides or shows `body`.
void section(const std::string& title, PanelUse use, const std::function<void()>& body);

// A text that is drawn over the views.
struct PanelLabel {
  double x = 0;  // position on the canvas (pixels); the text is drawn to the right of this point and above it
  double y = 0;
  std::string text{};
  PixelRect within{};     // rectangle of the view in which the text must lie
  bool mark = true;       // draws a small ring at (x, y)
  bool optional = false;  // true: left out if its text would overlap the text of an earlier label
};
void drawLabels(const std::vector<PanelLabel>& labels);
// Draws the name of one of several views and, if `active` is true, a frame around the view.
void drawCaption(const PixelRect& view, const std::string& text, bool active);
// Draws the reason why a view is empty, in large letters in the middle of the view.
void drawMessage(const PixelRect& view, const std::string& text);

// The user's click in a legend.
struct LegendClick {
  std::optional<std::size_t> entry;  // index of the clicked entry
  bool allEntries = false;           // true: the row for all entries was clicked
};
// Draws the entries of a legend and returns the entry that was clicked. `hidden`: whether each entry is hidden; empty:
// none is. `clickable`: the user can hide and show entries.
LegendClick drawLegendRows(const Legend& legend, const std::vector<bool>& hidden, bool clickable, PanelUse use);
// Draws a legend's scale; if interactive, with fields for its ends. Returns the ends if the user changes them.
std::optional<ScaleRange> drawScale(const Legend& legend, PanelUse use);
// Returns the rectangle of a legend with room for all entries: right of the picture's contents `body` or, if the
// picture would be wider than `maxWidth` pixels, below. Empty if the legend has no entries and no scale.
PixelRect legendRect(const Legend& legend, const PixelRect& body, double lineHeight, int maxWidth);

// A picture of images with a title above them.
struct LegendPicture {
  std::string title, details;          // texts at the left and the right of the title's row
  PixelRect body;                      // rectangle of the contents; the title is above it
  double lineHeight = 15;              // height of a line of text in pixels, see ImGuiLayer
  int maxWidth = 0;                    // see legendRect()
  std::vector<const Image*> images{};  // images of the contents, with the ids 0, 1 and so on
};
// Draws the picture with the legend in legendRect(). `drawBody` draws the contents. Throws Error like openOffscreen().
Image drawWithLegend(const LegendPicture& picture, const Legend& legend, const std::function<void()>& drawBody);

void textLine(const std::string& text);
void dimText(const std::string& text);
// Draws a text at a position (pixels of the canvas), shortened to `width` pixels.
void textAt(double x, double y, double width, const std::string& text);

// Draws a table of names and values. The row with the name `alarm` is highlighted as a warning.
void valueRows(const char* id, const NamedValues& rows, const std::string& alarm = "");
void heading(const std::string& text, const Rgb& color);
// Draws a tooltip beside the pointer.
void tooltip(const std::string& title, const Rgb& color, const NamedValues& rows, const std::string& alarm = "");

// Draws an image from setImage() in a rectangle, clipped at the panel's edge, with a ring around `mark` (pixels of the
// canvas). Returns true if the pointer is over the image.
bool imageAt(ImageId image, const PixelRect& rect, const std::optional<std::pair<double, double>>& mark = {});

// Draws messages in the lower left corner of `within`. Returns true if the user has dismissed the problems by a click.
bool drawMessages(const PixelRect& within, const std::vector<std::string>& problems,
                  const std::vector<std::string>& notices);

// Draws a window with the list of keys and their functions. Returns false if the user has closed it.
bool helpWindow(const NamedValues& keys);

}  // namespace scanmill
