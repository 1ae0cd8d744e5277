#pragma once

// What lies over the picture: title, legends, slider, labels, what a point holds, help, messages. Drawn by us, without
// a toolkit, so that it looks the same in a window and in a file, and what was clicked is known.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/canvas/canvas.h"
#include "viewer/coloring.h"
#include "viewer/image.h"

namespace scanmill {

// One of the pictures side by side.
struct HudPane {
  std::string caption;  // what is shown: "top, ray_tracing"; shown where there are several
  Legend legend;
  std::vector<bool> hidden;  // per entry of the legend; may be empty: none is
  bool clickable = false;    // entries can be hidden
  bool active = false;       // what keys change; marked where there are several
  std::string message{};     // why nothing is to be seen: large, in the middle
};

struct HudLabel {
  double x = 0;  // px, canvas; the label stands right and above
  double y = 0;
  std::string text;
  Rgb color = {255, 255, 255};
  bool mark = true;  // with a small ring at (x, y)
};

// Rows of name and value, in a box near the pointer that never leaves the canvas, or in a corner of a pane.
struct HudTip {
  int x = 0;  // px, canvas
  int y = 0;
  std::string heading;
  Rgb color{};  // beside the heading
  std::vector<std::pair<std::string, std::string>> rows;
  std::string alarm{};                           // name of a row that warns; empty: none does
  std::size_t pane = 0;                          // of one in a corner: that it belongs to
  std::vector<std::pair<int, int>> keepClear{};  // of one in a corner: px, places that it must not cover
};

// The scan as rings x columns, or a pass of an image, along the bottom or over the whole pane.
struct HudStrip {
  Image image;                              // row 0 on top; stretched by nearest pixels
  std::optional<std::pair<int, int>> mark;  // column and row that is pointed at
  std::string caption;
};

struct HudState {
  int width = 0;  // px, of the canvas
  int height = 0;
  std::string title;    // left of the title bar
  std::string summary;  // right of it
  std::vector<HudPane> panes;
  std::optional<std::size_t> frame;  // of a slider; none: no slider
  std::size_t frames = 0;
  std::string key;                   // of the frame
  std::vector<std::size_t> damaged;  // frames that cannot be shown, marked on the slider; ascending
  bool playing = false;
  std::string speed;                // of playing: "2x"
  std::optional<HudStrip> strip;    // below the panes
  std::optional<HudStrip> picture;  // in place of the panes, below their legends: as large as fits
  std::string busy;                 // what is being loaded; empty: nothing
  std::vector<std::string> problems;
  std::vector<std::string> notices;   // plain words: what a key did, a hint
  std::optional<std::string> prompt;  // being typed
  std::string promptCaption;          // "go to sample:"
  std::vector<std::string> promptHints;
  std::vector<HudLabel> labels;
  std::optional<HudTip> tip;
  std::optional<HudTip> docked;  // what was clicked: in a corner of a pane, so that it covers neither it nor a legend
  bool help = false;
  std::size_t helpFirst = 0;                              // line of the help that stands first where not all fit
  std::vector<std::pair<std::string, std::string>> keys;  // of the help: "c", "colour by the next column"
  bool still = false;                                     // a picture: nothing that is there to be pressed
  bool bare = false;                                      // nothing but labels: for pictures that are used elsewhere
};

enum class HudPart { Legend, LegendAll, Slider, PlayButton, Strip, Picture, Help, Problem, Panel };

// Where the pointer means something. Later regions lie over earlier ones.
struct HudRegion {
  HudPart part = HudPart::Panel;
  PixelRect rect;
  std::size_t pane = 0;   // of Legend, LegendAll
  std::size_t entry = 0;  // of Legend: into the legend's entries
};

struct HudLayout {
  double cell = 1;               // of the text, px
  std::vector<PixelRect> panes;  // where the 3D pictures stand; one per HudState::panes, at least one pixel each
  PixelRect strip;               // where the strip's image stands; empty without
  PixelRect picture;             // where the picture's image stands
};

// Panes stand side by side between the title bar and the strip, slider and such; they do not depend on tips, labels,
// help, notices or problems, so that the picture does not jump. Any size of canvas from 64 x 64 on.
HudLayout layoutHud(const HudState& state);

struct Hud {
  std::vector<Rgba> pixels;  // width x height
  std::vector<HudRegion> regions;
};

Hud drawHud(const HudState& state);

// Of the help where not all of its lines fit.
struct HelpPages {
  std::size_t lastFirst = 0;  // the last line that may stand first; 0: all fit
  std::size_t page = 1;       // lines
};
HelpPages helpPages(const HudState& state);

// The region that lies uppermost at a pixel; null where there is none.
const HudRegion* regionAt(const Hud& hud, int x, int y);

// Column and row of a strip's or picture's image at a pixel of the canvas; none outside.
std::optional<std::pair<int, int>> imagePixelAt(const PixelRect& rect, const Image& image, int x, int y);
// Frame that the slider shows when its region is clicked at x.
std::size_t sliderFrame(const PixelRect& slider, std::size_t frames, int x);

}  // namespace scanmill
