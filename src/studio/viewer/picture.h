#pragma once

// Draws scans as pictures, without a display. All functions that draw need the device that openOffscreen() needs, and
// throw Error if there is no such device.

#include <optional>
#include <string>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/coloring.h"
#include "viewer/image.h"
#include "viewer/range_strip.h"
#include "viewer/view_camera.h"

namespace scanmill {

constexpr int kLeastPictureSide = 64;
constexpr int kMostPictureSide = 8192;
// Maximum of width * height, slightly more than 8K has; drawing takes about 28 bytes per pixel.
constexpr int kMostPicturePixels = 36'000'000;

// Draws the scan as the viewer does from behind and above the sensor, with `title` and the number of points above it
// and the legend beside it. The picture of an empty scan says that it is empty. `depthEdges`: darkens points behind
// nearer surfaces (eye-dome lighting).
Image drawScan(const Scan& scan, const Coloring& coloring, int width, int height, const std::string& title,
               bool depthEdges = true);

// Returns the colour of a scan in an overlay of several scans. `scan`: index of the scan in the overlay.
Rgb overlayColor(std::size_t scan);

// Draws a scan as a range image with one row per ring, the highest beams at the top, and one pixel per beam, see
// makeRangeStrip(), and its legend beside it. Pixels are enlarged by integer factors until the image is readable. If
// several points are in the same pixel, the nearest is shown. `beams`: see makeRangeStrip(). Throws InputError if the
// scan is too large for a picture, or if it is not organised and has no columns `ring` and `column`.
Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title, const BeamTable* beams = nullptr);

}  // namespace scanmill
