#pragma once

// What the program and libscanmill_passes.so have in common, and all of it. Plain structs and functions that do not
// throw: each side frees what it allocated, and errors travel as text.

#include <cstdint>

extern "C" {

enum ScanmillVtkStatus : std::int32_t {
  kScanmillVtkDone,
  kScanmillVtkFailed,
  kScanmillVtkNoDevice,  // there is no OpenGL that will do
  kScanmillVtkOutOfMemory,
};

struct ScanmillVtkText {
  char text[1024];  // ends with a zero; cut where it is longer
};

struct ScanmillVtkLimits {
  std::uint32_t imageSize;          // px, of an image's longer side
  std::uint64_t trianglesPerBatch;  // that a call can draw from
};

// Triangles as corners, three after each other, without indices.
struct ScanmillVtkTriangles {
  std::uint64_t count;
  const float* positions;        // 3 a corner: m, in the frame of their mesh
  const float* uvs;              // 2 a corner; null where nothing is cut out
  const std::uint32_t* cutouts;  // one a corner: index into the cut-outs, the same for all three corners
};

// Where a texture lets the view pass: one bit a texel, set where it does. Texel (column, row) is bit
// 32 * firstWord + row * width + column; row 0 is at v = 0.
struct ScanmillVtkCutout {
  std::uint32_t firstWord;
  std::uint32_t width;
  std::uint32_t height;
  std::uint32_t unused;
};

struct ScanmillVtkScene {
  ScanmillVtkTriangles solid;
  ScanmillVtkTriangles cut;
  const ScanmillVtkCutout* cutouts;
  std::uint64_t cutoutCount;
  const std::uint32_t* words;  // of the cut-outs' bits
  std::uint64_t wordCount;
};

// One placing of a run of triangles. The number of its k-th triangle in the image is firstNumber + k; 0 is kept for
// pixels in which nothing is seen.
//
//   (x, y, w) of clip space = rows * (position, 1); depth grows with nearest / w
struct ScanmillVtkPlacement {
  float rows[3][4];
  std::uint32_t firstNumber;
};

// `placements` placings, from firstPlacement on, of the triangles [firstTriangle, firstTriangle + triangles).
struct ScanmillVtkDraw {
  std::uint32_t firstTriangle;
  std::uint32_t triangles;
  std::uint32_t firstPlacement;
  std::uint32_t placements;
};

struct ScanmillVtkImage {
  std::uint32_t width;  // px
  std::uint32_t height;
  float nearest;  // m, of the clipping plane w = nearest
  const ScanmillVtkPlacement* placements;
  std::uint64_t placementCount;
  const ScanmillVtkDraw* solid;  // in the order in which they are drawn: of equal depths the first stays
  std::uint64_t solidCount;
  const ScanmillVtkDraw* cut;
  std::uint64_t cutCount;
};

// How pixels are counted: row by row, through the images of slots 0 to 7.
struct ScanmillVtkPixels {
  std::uint32_t firsts[9];  // each image's first pixel, and one past the last
  std::uint32_t widths[8];  // px
};

struct ScanmillVtkRenderer;

// Calls may come from any thread, one after the other.
struct ScanmillVtkModule {
  std::uint32_t version;
  // Finds a device: `device` is its number among EGL's devices, "software", or null for the best one. `described` is
  // what draws, for reports.
  ScanmillVtkStatus (*open)(const char* device, ScanmillVtkRenderer** renderer, ScanmillVtkLimits* limits,
                            ScanmillVtkText* described, ScanmillVtkText* error);
  void (*close)(ScanmillVtkRenderer* renderer);
  ScanmillVtkStatus (*upload)(ScanmillVtkRenderer* renderer, const ScanmillVtkScene* scene, ScanmillVtkText* error);
  // Draws image number `slot` (0 to 7) and keeps it in place of the one before. Row 0 is the top one.
  ScanmillVtkStatus (*draw)(ScanmillVtkRenderer* renderer, std::uint32_t slot, const ScanmillVtkImage* image,
                            ScanmillVtkText* error);
  // Waits until everything asked for is done.
  ScanmillVtkStatus (*finish)(ScanmillVtkRenderer* renderer, ScanmillVtkText* error);
  // The numbers at `count` addresses, which belong to images that were drawn; one beyond them all gives 0.
  ScanmillVtkStatus (*gather)(ScanmillVtkRenderer* renderer, const ScanmillVtkPixels* pixels,
                              const std::uint32_t* addresses, std::uint64_t count, std::uint32_t* numbers,
                              ScanmillVtkText* error);
  // Whole rows of one image.
  ScanmillVtkStatus (*read)(ScanmillVtkRenderer* renderer, std::uint32_t slot, std::uint32_t firstRow,
                            std::uint32_t rows, std::uint32_t* numbers, ScanmillVtkText* error);
};

// The only symbol of the module.
const ScanmillVtkModule* scanmillVtkModule();
}

namespace scanmill {

constexpr std::uint32_t kVtkModuleVersion = 1;  // another one for every change of the structs above
constexpr const char* kVtkModuleSymbol = "scanmillVtkModule";
constexpr std::uint32_t kVtkImages = 8;  // at once

}  // namespace scanmill
