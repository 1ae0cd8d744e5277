#pragma once

// A canvas is a window, or an image without a window, on which VTK draws points, triangles and lines. It does not
// depend on scans. All coordinates are in metres in one frame, the canvas frame; they are float32, so they are exact
// only near the frame's origin. Each item may have a pose in this frame. Pixel coordinates start at the upper left
// corner. All functions of a canvas must be called on the thread that opened it. Only one window can be open at a time.
// VTK is in a plug-in, which is loaded when the first canvas is opened.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/module.h"
#include "base/vec.h"
#include "viewer/image.h"
#include "viewer/view_camera.h"

namespace scanmill {

constexpr std::size_t kCanvasViews = 4;  // maximum number of views at a time

using ItemId = std::uint32_t;              // chosen by the caller
using ImageId = std::uint32_t;             // chosen by the caller; may be equal to item ids
using Rgba = std::array<std::uint8_t, 4>;  // sRGB with alpha, not premultiplied

struct PixelRect {
  int left = 0, top = 0, width = 0, height = 0;

  bool contains(int x, int y) const { return x >= left && y >= top && x < left + width && y < top + height; }
  bool operator==(const PixelRect&) const = default;
};

// A rectangle of the canvas with a camera. The camera's centerX and centerY are half the rectangle's width and height.
// Items are drawn up to the depth `farthest` (m along the line of sight).
struct CanvasView {
  PixelRect rect{};
  ViewCamera camera{};
  double farthest = 1000;
  Rgb background{};
  bool depthEdges = true;  // darkens points behind nearer surfaces (eye-dome lighting)
};

// Kinds of elements of an item. The value is the number of corners per element.
enum class ItemKind : std::uint32_t { Points = 1, Segments = 2, Triangles = 3 };

struct ItemLook {
  Affine canvasFromItem{};
  double size = 1;          // pixels: side of a point, or width of a line
  double opacity = 1;       // opacity from 0 (invisible) to 1
  std::uint32_t views = 1;  // bit k: the item is drawn in view k
  bool lit = true;          // shades triangles with a light at the eye
};

// A corner of a triangle of the overlay. The overlay contains panels and text, and is drawn on top of the views. The
// colours of a triangle are multiplied by the colours of an image. Later triangles are on top of earlier ones.
struct OverlayVertex {
  float x = 0;  // position on the canvas (pixels)
  float y = 0;
  float u = 0;  // texture coordinates from 0 to 1; the origin is the image's upper left corner
  float v = 0;
  Rgba color{};
};
struct OverlayPart {
  PixelRect clip;         // rectangle of the canvas (pixels); nothing is drawn outside
  ImageId image = 0;      // an image from setImage()
  std::size_t first = 0;  // index of the part's first entry in Overlay::corners
  std::size_t count = 0;  // number of entries in Overlay::corners, three per triangle
};
struct Overlay {
  std::vector<OverlayVertex> vertices;
  std::vector<std::uint32_t> corners;  // indices in `vertices`
  std::vector<OverlayPart> parts;
};

struct CanvasEvent {
  enum class Kind {
    Key,     // a key was pressed, or is repeated automatically
    Move,    // the pointer was moved
    Down,    // a mouse button was pressed
    Up,      // a mouse button was released
    Wheel,   // the mouse wheel was turned by `amount`
    Resize,  // the canvas has a new size; also sent when the window first appears
    Redraw,  // the window must be redrawn
    Tick,    // sent every `tickMilliseconds` milliseconds, see Canvas::run()
    Close,   // the user closes the window; no further events follow
  };
  Kind kind = Kind::Tick;
  // The typed character such as "a", "A", "[" or " ", or the key's name such as "Left", "Return" or "F1".
  std::string key{};
  std::string text{};  // the typed text in UTF-8; may be empty
  int x = 0;           // pixel of the pointer; may be outside of the canvas while a button is pressed
  int y = 0;
  int button = 0;  // 1: left, 2: middle, 3: right
  int clicks = 1;  // 2: the second press of a double click
  bool shift = false;
  bool control = false;
  double amount = 0;  // steps of the wheel, positive away from the user
  int width = 0;      // size of the canvas in pixels
  int height = 0;
};

// Draws items and an overlay. Copies all data that it receives. All functions may throw Error.
class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual int width() const = 0;  // width in pixels
  virtual int height() const = 0;
  // Returns the display's scale factor for text, such as 2 for a display of high resolution; 1 if there is no window.
  virtual double scale() const = 0;
  // Sets the views: at most kCanvasViews rectangles, which must not overlap. Pixels outside of all views are black.
  virtual void setViews(std::span<const CanvasView> views) = 0;
  // Sets the elements of an item. Each element has one colour, and ItemKind states its number of corners. If the item
  // exists, replaces its elements and keeps its look. Elements with coordinates that are not finite are not drawn.
  virtual void set(ItemId item, ItemKind kind, std::span<const Vec3f> corners, std::span<const Rgb> colors) = 0;
  // Sets the colours of an item's elements: one per point, triangle or segment.
  virtual void setColors(ItemId item, std::span<const Rgb> colors) = 0;
  // Draws only the elements of an item with these indices (ascending; may be empty); nullopt: all elements.
  virtual void show(ItemId item, std::optional<std::vector<std::uint32_t>> indices) = 0;
  virtual void setLook(ItemId item, const ItemLook& look) = 0;
  virtual void drop(ItemId item) = 0;  // removes an item; does nothing if it does not exist
  // Sets an image for overlays, or replaces the image with this id. `pixels`: row by row, starting with the top row.
  // Enlarged images are not interpolated, so that their pixels are visible as squares.
  virtual void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels) = 0;
  // Sets the overlay. It is drawn on top of all views until it is replaced.
  virtual void setOverlay(Overlay overlay) = 0;
  // Draws the views and the overlay. If `maxPoints` is not 0, draws at most this number of points of each item, evenly
  // chosen, to be fast during motion.
  virtual void render(std::uint64_t maxPoints = 0) = 0;
  virtual Image read() = 0;  // returns the picture that was drawn last
  // Shows the window and passes its events to `handle`, and a Tick every `tickMilliseconds`, until `handle`
  // returns false or the window is closed. `handle` may call all functions except run() and may throw; run() rethrows.
  virtual void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handle) = 0;
};

// Opens a window on the display that the environment variable DISPLAY names. `width`, `height`: in pixels. Throws Error
// if there is no display or no OpenGL, or if the plug-in is missing; the message says what to do.
std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height);
// Creates a canvas without a window on the device namedDevice() (gpu/device.h). Throws Error without device or plug-in.
std::unique_ptr<Canvas> openOffscreen(int width, int height);

// Writes the picture that was drawn last to scanmill_view_000.png in the current folder, or to the file with the first
// number that is not used yet. Returns the file. Throws Error if all numbers are used or the file cannot be written.
std::filesystem::path savePictureOf(Canvas& canvas);

// The plug-in libscanmill_viewer.so (base/module.h), which draws with VTK in a GLFW window or, off screen, with EGL.
class CanvasModule {
 public:
  static constexpr ModuleFile kFile{
      "libscanmill_viewer.so", "nothing can be shown by VTK",
      "install VTK, EGL and GLFW (on Debian the packages libvtk9-dev, libegl-dev and libglfw3-dev)"};
  virtual ~CanvasModule() = default;
  // These functions implement openWindow() and openOffscreen().
  virtual std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height) const = 0;
  virtual std::unique_ptr<Canvas> openOffscreen(const std::string& device, int width, int height) const = 0;
};

}  // namespace scanmill
