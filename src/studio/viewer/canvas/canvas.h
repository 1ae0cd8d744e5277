#pragma once

// A window or an image on which points, triangles and lines are drawn, by VTK (viewer/canvas/canvas_module.h). Metres
// in the canvas's own frame; pixels from the upper left corner. A canvas is used by the thread that opened it.

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

// A window cannot be opened: there is no display. What to do is said.
class NoDisplay : public Error {
 public:
  using Error::Error;
};

using ItemId = std::uint32_t;
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
  bool depthEdges = true;
};

struct ItemLook {
  Affine canvasFromItem;
  double size = 1;          // px
  double opacity = 1;       // 0 to 1
  std::uint32_t views = 1;  // bit k: drawn in view k
  bool lit = true;          // triangles
};

struct CanvasEvent {
  enum class Kind { Key, Move, Down, Up, Wheel, Resize, Expose, Tick, Close };
  Kind kind = Kind::Tick;
  std::string key;   // X's name of its symbol: "a", "A", "Left", "Return"
  std::string text;  // what it types, UTF-8; may be empty
  int x = 0;         // px, the pointer
  int y = 0;
  int button = 0;  // 1 left, 2 middle, 3 right
  int clicks = 1;  // 2: the second press of a double click
  bool shift = false;
  bool control = false;
  double amount = 0;  // of Wheel: steps, away from the person positive
  int width = 0;      // px, of the canvas
  int height = 0;
};

class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual std::string device() const = 0;  // what draws
  virtual int width() const = 0;
  virtual int height() const = 0;
  virtual void resize(int width, int height) = 0;
  virtual void setViews(std::span<const CanvasView> views) = 0;  // at most kCanvasViews
  virtual void setPoints(ItemId item, std::span<const Vec3f> positions, std::span<const Rgb> colors) = 0;
  // Three corners a triangle, two ends a segment; one colour each.
  virtual void setTriangles(ItemId item, std::span<const Vec3f> corners, std::span<const Rgb> colors) = 0;
  virtual void setLines(ItemId item, std::span<const Vec3f> ends, std::span<const Rgb> colors) = 0;
  virtual void setColors(ItemId item, std::span<const Rgb> colors) = 0;
  virtual void showAll(ItemId item) = 0;
  virtual void showOnly(ItemId item, std::span<const std::uint32_t> indices) = 0;  // ascending; may be none
  virtual void setLook(ItemId item, const ItemLook& look) = 0;
  virtual void drop(ItemId item) = 0;
  virtual void setOverlay(int width, int height, std::span<const Rgba> pixels) = 0;  // 0 x 0: none
  virtual void render(std::uint64_t mostPoints = 0) = 0;                             // 0: all
  virtual Image read() = 0;                                                          // what was last drawn
  // Of a window: until `handle` returns false or the window is closed. What `handle` throws ends it and is thrown on.
  virtual void run(int tickMilliseconds, const std::function<bool(const CanvasEvent&)>& handle) = 0;
};

// Throws NoDisplay, or Error where there is no OpenGL or the module is missing.
std::unique_ptr<Canvas> openWindow(const std::string& title, int width, int height);
// An image, without a display. SCANMILL_GL_DEVICE chooses the device, as for the depth camera.
std::unique_ptr<Canvas> openOffscreen(int width, int height);

}  // namespace scanmill
