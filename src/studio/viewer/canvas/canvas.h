#pragma once

// A canvas is a window, or an image without a window, on which VTK draws points, triangles and lines. It knows nothing
// of scans. Everything is in metres in one frame, the canvas frame (float32 near its origin); an item may be placed in
// that frame at a pose of its own. Pixels count from the upper left corner. All calls of a canvas come from the thread
// that opened it. Only one window is open at a time. VTK is in a plug-in (viewer/canvas/canvas_interface.h), loaded
// with the first canvas.

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

// Thrown if a window cannot be opened because there is no display. The text says what to do.
class NoDisplay : public Error {
 public:
  using Error::Error;
};

constexpr std::size_t kCanvasViews = 8;  // greatest number of views at the same time

using ItemId = std::uint32_t;              // chosen by the caller
using ImageId = std::uint32_t;             // chosen by the caller, independent of item ids
using Rgba = std::array<std::uint8_t, 4>;  // sRGB, alpha not premultiplied

struct PixelRect {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  bool contains(int x, int y) const { return x >= left && y >= top && x < left + width && y < top + height; }
  bool operator==(const PixelRect&) const = default;
};

// The camera looks through the middle of the rectangle (its centerX and centerY are half the rectangle's sides). It
// draws everything up to the depth `farthest` (m, along the line of sight).
struct CanvasView {
  PixelRect rect;
  ViewCamera camera;
  double farthest = 1000;
  Rgb background{};
  bool depthEdges = true;  // points behind a nearer surface are darkened (eye-dome lighting)
};

struct ItemLook {
  Affine canvasFromItem;
  double size = 1;          // px: side of a point, width of a line
  double opacity = 1;       // 0 to 1
  std::uint32_t views = 1;  // bit k: drawn in view k
  bool lit = true;          // triangles are shaded by a light at the eye
  bool round = false;       // points are discs instead of squares
};

// The overlay is drawn over the views: the triangles of panels and their text. Each triangle multiplies its colours by
// those of an image. Later triangles are drawn over earlier ones.
struct OverlayVertex {
  float x = 0;  // px of the canvas
  float y = 0;
  float u = 0;  // texture coordinates: 0 to 1, from the image's left and upper edge
  float v = 0;
  Rgba color{};
};
struct OverlayPart {
  PixelRect clip;         // px of the canvas: nothing is drawn outside
  ImageId image = 0;      // an image that setImage() has set
  std::size_t first = 0;  // index into Overlay::corners
  std::size_t count = 0;  // number of Overlay::corners, three per triangle
};
struct Overlay {
  std::vector<OverlayVertex> vertices;
  std::vector<std::uint32_t> corners;  // indices into `vertices`
  std::vector<OverlayPart> parts;
};

struct CanvasEvent {
  enum class Kind {
    Key,     // a key was pressed, also by auto-repeat
    Move,    // the pointer moved
    Down,    // a button went down
    Up,      // a button went up
    Wheel,   // the wheel turned by `amount`
    Resize,  // width and height are new; also sent when the window first appears
    Redraw,  // the window must be drawn again
    Tick,    // the tickMilliseconds of run() have passed
    Close,   // the user closes the window: the last event
  };
  Kind kind = Kind::Tick;
  std::string key;   // the character typed: "a", "A", "[", " "; or the name of another key: "Left", "Return", "F1"
  std::string text;  // the text typed, UTF-8; may be empty
  int x = 0;         // px, the pointer; may lie outside the canvas while a button is down
  int y = 0;
  int button = 0;  // 1 left, 2 middle, 3 right
  int clicks = 1;  // 2: the second press of a double click
  bool shift = false;
  bool control = false;
  double amount = 0;  // steps of the wheel, positive away from the user
  int width = 0;      // px, of the canvas
  int height = 0;
};

// A canvas copies all data that it is given. All its functions may throw Error.
class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual std::string device() const = 0;  // name of the device that draws, for reports
  virtual int width() const = 0;           // px
  virtual int height() const = 0;
  // Returns the display's scale of text: 1 is usual, 2 the scale of the densest displays; 1 without a window.
  virtual double scale() const = 0;
  virtual void resize(int width, int height) = 0;
  // Sets the views that are drawn: at most kCanvasViews rectangles, which do not overlap. Pixels outside all are black.
  virtual void setViews(std::span<const CanvasView> views) = 0;
  // Set the elements of an item. Three corners make a triangle, two ends a segment; each element has one colour. An
  // existing item is replaced, and keeps its look. Points that are not finite are never drawn.
  virtual void setPoints(ItemId item, std::span<const Vec3f> positions, std::span<const Rgb> colors) = 0;
  virtual void setTriangles(ItemId item, std::span<const Vec3f> corners, std::span<const Rgb> colors) = 0;
  virtual void setLines(ItemId item, std::span<const Vec3f> ends, std::span<const Rgb> colors) = 0;
  // Gives new colours to an item, one for each of its points, triangles or segments.
  virtual void setColors(ItemId item, std::span<const Rgb> colors) = 0;
  // Draws only these points, triangles or segments of an item from now on. The indices ascend; the list may be empty.
  virtual void showOnly(ItemId item, std::span<const std::uint32_t> indices) = 0;
  virtual void showAll(ItemId item) = 0;
  virtual void setLook(ItemId item, const ItemLook& look) = 0;
  virtual void drop(ItemId item) = 0;  // does nothing if the item does not exist
  // Sets an image for overlays, the upper row first; replaces an image of the same id. Enlarged images are not
  // interpolated: their pixels stay squares.
  virtual void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels) = 0;
  // Sets the overlay, which is drawn over all views until it is replaced.
  virtual void setOverlay(Overlay overlay) = 0;
  // Draws the views and the overlay. At most `mostPoints` points of each item, spread over the item, are drawn, for
  // speed while something moves; 0: all points.
  virtual void render(std::uint64_t mostPoints = 0) = 0;
  virtual Image read() = 0;  // returns the last picture drawn
  // Shows a window and gives its events to `handle` until `handle` returns false or the window is closed. `handle` may
  // call every function except run(). An exception of `handle` ends the run and is rethrown.
  virtual void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handle) = 0;
};

// Opens a window on the display that DISPLAY names. Throws NoDisplay, and Error if there is no OpenGL or the plug-in is
// missing.
std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height);
// Creates an image without a display, drawn by the device that namedDevice() names (gpu/device.h). Throws Error.
std::unique_ptr<Canvas> openOffscreen(int width, int height);

}  // namespace scanmill
