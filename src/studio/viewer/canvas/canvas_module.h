#pragma once

// What the program and libscanmill_viewer.so have in common, and all of it. Plain structs and functions that do not
// throw: each side frees what it allocated, and errors travel as text.
//
// A canvas is a window, or an image without one, on which points, triangles and lines are drawn by VTK. It knows
// nothing of scans. Everything is metres in one frame, the canvas's own (float32 near its origin); an item may stand in
// it at a pose of its own. Colours are sRGB, 8 bit. Pixels count from the upper left corner.
//
// All calls of a canvas come from the thread that opened it; of windows there is one at a time.

#include <cstdint>

extern "C" {

enum ScanmillCanvasStatus : std::int32_t {
  kScanmillCanvasDone,
  kScanmillCanvasFailed,
  kScanmillCanvasNoDisplay,  // no X server takes a window
  kScanmillCanvasNoDevice,   // there is no OpenGL that will do
  kScanmillCanvasOutOfMemory,
};

struct ScanmillCanvasText {
  char text[1024];  // ends with a zero; cut where it is longer
};

struct ScanmillCanvas;

struct ScanmillCanvasOptions {
  const char* title;     // of the window
  std::uint32_t width;   // px
  std::uint32_t height;  // px
  std::uint32_t window;  // 1: a window on the display that DISPLAY names; 0: an image, by EGL, without an X server
  const char* device;    // of images: see ScanmillVtkModule::open; null for the best one
};

// A rectangle of the canvas and the camera through which it is seen.
struct ScanmillCanvasView {
  std::uint32_t left, top, width, height;  // px
  std::uint8_t background[4];              // rgb, and unused
  double eye[3];                           // m
  double forward[3];                       // unit: the line of sight
  double up[3];                            // unit: the image's upward direction, square to `forward`
  double focal;                            // px: a pinhole's focal length; orthographic: pixels per metre
  double nearest, farthest;                // m along `forward`: what lies outside is not drawn
  std::uint32_t orthographic;              // 1 or 0
  std::uint32_t depthEdges;                // 1: points behind a nearer surface are darkened (eye-dome lighting)
};

struct ScanmillCanvasPoints {
  std::uint64_t count;
  const float* positions;      // 3 a point; those that are not finite are never drawn
  const std::uint8_t* colors;  // 3 a point
};

struct ScanmillCanvasTriangles {
  std::uint64_t count;
  const float* corners;        // 9 a triangle
  const std::uint8_t* colors;  // 3 a triangle
};

struct ScanmillCanvasLines {
  std::uint64_t count;         // of segments
  const float* ends;           // 6 a segment
  const std::uint8_t* colors;  // 3 a segment
};

struct ScanmillCanvasLook {
  double canvasFromItem[16];  // affine, row by row, for column vectors
  float size;                 // px: side of a point, width of a line
  float opacity;              // 0 to 1
  std::uint32_t views;        // bit k: drawn in view k
  std::uint32_t lit;          // triangles: 1: shaded by a light at the eye, 0: in their plain colours
};

enum ScanmillCanvasEventKind : std::uint32_t {
  kScanmillCanvasKey,   // pressed, also by auto-repeat
  kScanmillCanvasMove,  // the pointer moved
  kScanmillCanvasDown,  // a button went down
  kScanmillCanvasUp,
  kScanmillCanvasWheel,   // `amount` steps, away from the person positive
  kScanmillCanvasResize,  // width and height are new; also when the window first stands
  kScanmillCanvasExpose,  // the window wants to be drawn again
  kScanmillCanvasTick,    // so many milliseconds have passed
  kScanmillCanvasClose,   // the window is closed by its frame: the last event
};

struct ScanmillCanvasEvent {
  ScanmillCanvasEventKind kind;
  char key[32];          // X's name of the key's symbol: "a", "A", "Left", "Return", "BackSpace", "slash", "F1"
  char text[8];          // what it types, UTF-8; empty for keys that type nothing
  std::int32_t x, y;     // px, of the pointer; may lie outside while a button is down
  std::uint32_t button;  // 1 left, 2 middle, 3 right
  std::uint32_t clicks;  // 2 for the second press of a double click
  std::uint32_t shift, control;
  double amount;
  std::uint32_t width, height;  // px, of the canvas
};

// Called by run(). 0 ends it.
typedef std::int32_t (*ScanmillCanvasHandler)(void* self, const ScanmillCanvasEvent* event);

struct ScanmillCanvasModule {
  std::uint32_t version;
  // `described` is what draws, for reports.
  ScanmillCanvasStatus (*open)(const ScanmillCanvasOptions* options, ScanmillCanvas** canvas,
                               ScanmillCanvasText* described, ScanmillCanvasText* error);
  void (*close)(ScanmillCanvas* canvas);
  ScanmillCanvasStatus (*resize)(ScanmillCanvas* canvas, std::uint32_t width, std::uint32_t height,
                                 ScanmillCanvasText* error);
  // The rectangles drawn, at most 8, none over another; what none covers is black.
  ScanmillCanvasStatus (*views)(ScanmillCanvas* canvas, const ScanmillCanvasView* views, std::uint32_t count,
                                ScanmillCanvasText* error);
  // Items are numbers of the caller's choice; one that is there already is replaced, and keeps its look. A new one has
  // the identity, size 1, opacity 1, view 0, lit. What is passed is copied.
  ScanmillCanvasStatus (*points)(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasPoints* points,
                                 ScanmillCanvasText* error);
  ScanmillCanvasStatus (*triangles)(ScanmillCanvas* canvas, std::uint32_t item,
                                    const ScanmillCanvasTriangles* triangles, ScanmillCanvasText* error);
  ScanmillCanvasStatus (*lines)(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasLines* lines,
                                ScanmillCanvasText* error);
  // New colours of an item, as many as it has points, triangles or segments.
  ScanmillCanvasStatus (*colors)(ScanmillCanvas* canvas, std::uint32_t item, const std::uint8_t* colors,
                                 ScanmillCanvasText* error);
  // Only these points, triangles or segments of an item are drawn from now on (ascending); null: all.
  ScanmillCanvasStatus (*shown)(ScanmillCanvas* canvas, std::uint32_t item, const std::uint32_t* indices,
                                std::uint64_t count, ScanmillCanvasText* error);
  ScanmillCanvasStatus (*look)(ScanmillCanvas* canvas, std::uint32_t item, const ScanmillCanvasLook* look,
                               ScanmillCanvasText* error);
  void (*drop)(ScanmillCanvas* canvas, std::uint32_t item);  // nothing where there is no such item
  // An image over the whole canvas, above everything: rgba, alpha not premultiplied, the upper row first, kept until
  // the next. It is not stretched: what it has too much is cut off on the right and at the bottom. Null: none.
  ScanmillCanvasStatus (*overlay)(ScanmillCanvas* canvas, std::uint32_t width, std::uint32_t height,
                                  const std::uint8_t* rgba, ScanmillCanvasText* error);
  // Draws. `mostPoints`: of every item of points only so many, spread over it, for speed while something moves; 0: all.
  ScanmillCanvasStatus (*render)(ScanmillCanvas* canvas, std::uint64_t mostPoints, ScanmillCanvasText* error);
  // What was last drawn: rgb, width * height, the upper row first.
  ScanmillCanvasStatus (*read)(ScanmillCanvas* canvas, std::uint8_t* rgb, ScanmillCanvasText* error);
  // Of a window: shows it and gives its events to the handler until that returns 0 or the window is closed. The handler
  // may call everything but run() and close().
  ScanmillCanvasStatus (*run)(ScanmillCanvas* canvas, std::uint32_t tickMilliseconds, ScanmillCanvasHandler handler,
                              void* self, ScanmillCanvasText* error);
};

// The only symbol of the module.
const ScanmillCanvasModule* scanmillCanvasModule();
}

namespace scanmill {

constexpr std::uint32_t kCanvasModuleVersion = 1;  // another one for every change of the structs above
constexpr const char* kCanvasModuleSymbol = "scanmillCanvasModule";
constexpr std::uint32_t kCanvasViews = 8;  // at once

}  // namespace scanmill
