#pragma once

// A canvas is a window, or an image without one, on which VTK draws points, triangles and lines. It knows nothing of
// scans. Everything is in metres in one frame, the canvas's own (float32 near its origin); an item may stand in it at a
// pose of its own. Pixels count from the upper left corner. All calls of a canvas come from the thread that opened it.
// Of windows there is one at a time. VTK is in a module (viewer/canvas/canvas_interface.h), loaded with the first
// canvas.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "viewer/image.h"
#include "viewer/view_camera.h"

namespace scanmill {

// A window cannot be opened, since there is no display. The text says what to do.
class NoDisplay : public Error {
 public:
  using Error::Error;
};

constexpr std::size_t kCanvasViews = 8;  // at once

using ItemId = std::uint32_t;              // a number of the caller's choice
using ImageId = std::uint32_t;             // of images, another one
using Rgba = std::array<std::uint8_t, 4>;  // sRGB, alpha not premultiplied

struct PixelRect {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  bool contains(int x, int y) const { return x >= left && y >= top && x < left + width && y < top + height; }
  bool operator==(const PixelRect&) const = default;
};

// The camera looks through the middle of the rectangle (its centerX and centerY are half the rectangle's sides). What
// it sees up to `farthest` (m, along its line of sight) is drawn.
struct CanvasView {
  PixelRect rect;
  ViewCamera camera;
  double farthest = 1000;
  Rgb background{};
  bool depthEdges = true;  // points behind a nearer surface are darkened (eye-dome lighting)
};

struct ItemLook {
  Affine canvasFromItem;
  double size = 1;          // px: the side of a point, the width of a line
  double opacity = 1;       // 0 to 1
  std::uint32_t views = 1;  // bit k: drawn in view k
  bool lit = true;          // triangles are shaded by a light at the eye
  bool round = false;       // points are discs, in place of squares
};

// What lies over the views, as panels and their text are made of: triangles, each of which multiplies its colours with
// an image's. Later ones lie over earlier ones.
struct OverlayVertex {
  float x = 0;  // px of the canvas
  float y = 0;
  float u = 0;  // of the image: 0 to 1, from its left and upper edge
  float v = 0;
  Rgba color{};
};
struct OverlayPart {
  PixelRect clip;     // px of the canvas: nothing is drawn outside
  ImageId image = 0;  // that setImage() has been given
  std::size_t first = 0;
  std::size_t count = 0;  // of Overlay::corners, three a triangle
};
struct Overlay {
  std::vector<OverlayVertex> vertices;
  std::vector<std::uint32_t> corners;  // into `vertices`
  std::vector<OverlayPart> parts;
};

struct CanvasEvent {
  enum class Kind {
    Key,     // a key was pressed, also by auto-repeat
    Move,    // the pointer moved
    Down,    // a button went down
    Up,      // a button went up
    Wheel,   // the wheel turned by `amount`
    Resize,  // width and height are new; also when the window first stands
    Redraw,  // the window wants to be drawn again
    Tick,    // so many milliseconds have passed
    Close,   // the window is closed by its frame: the last event
  };
  Kind kind = Kind::Tick;
  std::string key;   // what it types: "a", "A", "[", " "; or its name where it types nothing: "Left", "Return", "F1"
  std::string text;  // what it types, UTF-8; may be empty
  int x = 0;         // px, the pointer; may lie outside while a button is down
  int y = 0;
  int button = 0;  // 1 left, 2 middle, 3 right
  int clicks = 1;  // 2: the second press of a double click
  bool shift = false;
  bool control = false;
  double amount = 0;  // of Wheel: steps, away from the person positive
  int width = 0;      // px, of the canvas
  int height = 0;
};

// What is passed to a canvas is copied. Its calls throw Error.
class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual std::string device() const = 0;  // what draws, for reports
  virtual int width() const = 0;           // px
  virtual int height() const = 0;
  // How many times as many pixels as usual a display has for its letters: 2 for the densest; 1 without a window.
  virtual double scale() const = 0;
  virtual void resize(int width, int height) = 0;
  // Sets the rectangles that are drawn, at most kCanvasViews, none over another. What none covers is black.
  virtual void setViews(std::span<const CanvasView> views) = 0;
  // Three corners make a triangle, two ends a segment; each has one colour. An item that is there already is replaced,
  // and keeps its look. Points that are not finite are never drawn.
  virtual void setPoints(ItemId item, std::span<const Vec3f> positions, std::span<const Rgb> colors) = 0;
  virtual void setTriangles(ItemId item, std::span<const Vec3f> corners, std::span<const Rgb> colors) = 0;
  virtual void setLines(ItemId item, std::span<const Vec3f> ends, std::span<const Rgb> colors) = 0;
  // Gives new colours to an item, as many as it has points, triangles or segments.
  virtual void setColors(ItemId item, std::span<const Rgb> colors) = 0;
  // Only these points, triangles or segments of an item are drawn from now on. The indices ascend; there may be none.
  virtual void showOnly(ItemId item, std::span<const std::uint32_t> indices) = 0;
  virtual void showAll(ItemId item) = 0;
  virtual void setLook(ItemId item, const ItemLook& look) = 0;
  virtual void drop(ItemId item) = 0;  // does nothing where there is no such item
  // An image that overlays may show, the upper row first; it replaces one that is there. Where it is enlarged, its
  // pixels stay squares.
  virtual void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels) = 0;
  // Lies above everything until the next.
  virtual void setOverlay(Overlay overlay) = 0;
  // Draws. Of every item of points only so many are drawn, spread over it, for speed while something moves; 0: all.
  virtual void render(std::uint64_t mostPoints = 0) = 0;
  virtual Image read() = 0;  // what was last drawn
  // Shows a window and gives its events to `handle` until that returns false or the window is closed. `handle` may call
  // everything but run(). What it throws ends the run and is thrown on.
  virtual void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handle) = 0;
};

// Opens a window on the display that DISPLAY names. Throws NoDisplay, and Error where there is no OpenGL or the module
// is missing.
std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height);
// Makes an image, without a display, by the device that namedDevice() names (gpu/device.h). Throws Error.
std::unique_ptr<Canvas> openOffscreen(int width, int height);

}  // namespace scanmill
