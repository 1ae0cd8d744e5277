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

// Computing on the device that draws, in a context of its own. Its programs and buffers are numbers that it gives out,
// none of them 0.
struct ScanmillCompute;

struct ScanmillComputeLimits {
  std::uint64_t bufferBytes;     // of a buffer that a program reads or writes
  std::uint64_t tableTexels;     // of a table
  std::uint64_t parameterBytes;  // of a program's parameters
  std::uint32_t buffers;         // that a program reads or writes
  std::uint32_t tables;          // that a program reads
  std::uint32_t software;        // 1: it runs on the processor
  std::uint32_t unused;
};

enum ScanmillComputeTexel : std::uint32_t {
  kScanmillUint16,
  kScanmillUint32,
  kScanmillUint32x4,
  kScanmillFloat32x4,
};

// A buffer that a program only reads, by texelFetch() from a buffer texture.
struct ScanmillComputeTable {
  std::uint32_t buffer;
  ScanmillComputeTexel texel;
};

// A piece of a buffer, and where it comes from or goes to.
struct ScanmillComputeSource {
  std::uint64_t offset;
  std::uint64_t bytes;
  const void* data;
};
struct ScanmillComputeTarget {
  std::uint64_t offset;
  std::uint64_t bytes;
  void* data;
};

struct ScanmillComputeRun {
  std::uint32_t program;
  std::uint32_t bufferCount;
  const std::uint32_t* buffers;  // number k becomes the storage buffer of binding k
  std::uint64_t tableCount;
  const ScanmillComputeTable* tables;  // number k becomes the buffer texture of binding k
  const void* parameters;              // the uniform block of binding 0, laid out by std140
  std::uint64_t parameterBytes;
  std::uint64_t invocations;  // less than 2^32
};

// Calls may come from any thread, one after the other.
struct ScanmillComputeFunctions {
  // See ScanmillVtkModule::open. Nothing of VTK is started.
  ScanmillVtkStatus (*open)(const char* device, ScanmillCompute** compute, ScanmillComputeLimits* limits,
                            ScanmillVtkText* described, ScanmillVtkText* error);
  void (*close)(ScanmillCompute* compute);
  // `text`: GLSL 4.30 without the version line and main(); it defines `void invoke(uint i)`.
  ScanmillVtkStatus (*makeProgram)(ScanmillCompute* compute, const char* name, const char* text, std::uint32_t* program,
                                   ScanmillVtkText* error);
  ScanmillVtkStatus (*makeBuffer)(ScanmillCompute* compute, std::uint32_t* buffer, ScanmillVtkText* error);
  void (*dropProgram)(ScanmillCompute* compute, std::uint32_t program);
  void (*dropBuffer)(ScanmillCompute* compute, std::uint32_t buffer);
  // Gives the buffer so many bytes, of any contents.
  ScanmillVtkStatus (*resize)(ScanmillCompute* compute, std::uint32_t buffer, std::uint64_t bytes,
                              ScanmillVtkText* error);
  ScanmillVtkStatus (*write)(ScanmillCompute* compute, std::uint32_t buffer, const ScanmillComputeSource* pieces,
                             std::uint64_t count, ScanmillVtkText* error);
  ScanmillVtkStatus (*read)(ScanmillCompute* compute, std::uint32_t buffer, const ScanmillComputeTarget* pieces,
                            std::uint64_t count, ScanmillVtkText* error);
  // Runs invoke() for 0 to invocations - 1. What is written shows in later runs and reads.
  ScanmillVtkStatus (*run)(ScanmillCompute* compute, const ScanmillComputeRun* run, ScanmillVtkText* error);
  // Waits until everything asked for is done.
  ScanmillVtkStatus (*finish)(ScanmillCompute* compute, ScanmillVtkText* error);
};

// Calls may come from any thread, one after the other.
struct ScanmillVtkModule {
  std::uint32_t version;
  const ScanmillComputeFunctions* compute;
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

constexpr std::uint32_t kVtkModuleVersion = 2;  // another one for every change of the structs above
constexpr const char* kVtkModuleSymbol = "scanmillVtkModule";
constexpr std::uint32_t kVtkImages = 8;  // at once

}  // namespace scanmill
