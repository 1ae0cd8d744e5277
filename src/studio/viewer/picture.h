#pragma once

// Draws scans, and EXR images of render passes and hits, as pictures, without a display. All functions that draw need
// the device that openOffscreen() needs, and throw Error if there is no such device.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/coloring.h"
#include "viewer/range_strip.h"

namespace scanmill {

constexpr int kLeastPictureSide = 64;
constexpr int kMostPictureSide = 8192;
// Maximum of width * height, slightly more than 8K has; drawing takes about 28 bytes per pixel.
constexpr int kMostPicturePixels = 36'000'000;

// Draws a scan as seen from behind and above the sensor, with `title` and the number of points in a row at the top, and
// the legend beside the points. The picture of an empty scan says that it is empty. `depthEdges`: darkens points behind
// nearer surfaces (eye-dome lighting).
Image drawScan(const Scan& scan, const Coloring& coloring, int width, int height, const std::string& title,
               bool depthEdges = true);

// Returns the colour of a scan in an overlay of several scans. `scan`: index of the scan in the overlay.
Rgb overlayColor(std::size_t scan);

// Draws a scan as a range image with its legend beside it. The image has one row per ring, the highest beams at the
// top, and one pixel per beam; see makeRangeStrip(). Pixels are enlarged by integer factors until the image is
// readable. If several points are in the same pixel, the nearest is shown. `beams`: see makeRangeStrip(). Throws
// InputError if the scan is too large for a picture, or if it is not organised and has no columns `ring` and `column`.
Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title, const BeamTable* beams = nullptr);

// An EXR file, with the names of classes and materials that its recording states.
struct ExrSource {
  std::filesystem::path file;
  std::optional<Ontology> ontology{};    // absent: the names and colours of classes are unknown
  std::vector<std::string> materials{};  // names by material id; materials without a name are shown by id
};

// Finds an EXR file. `path`: the file, or the folder of a recording, in which `imageName` specifies the image
// (findKey()). Images are in the order of their names, numbers in numerical order. Throws InputError if there is none.
ExrSource findExr(const std::filesystem::path& path, const std::string& imageName);

// Draws the plane `planeName` with a legend beside it or, if `planeName` is empty, all planes side by side, in a
// picture `width` pixels wide. Depth is coloured on a logarithmic scale, normals by their components (x red, y green, z
// blue; 0.5 means zero), ids by one colour each, material properties on a scale from 0 to 1 (retroreflectance from 0 to
// its maximum). Planes of hits have one row per ring, ring 0 at the top. Throws InputError if there is no such plane.
Image drawExr(const ExrSource& source, const std::string& planeName, int width);

}  // namespace scanmill
