#pragma once

// Draws scans as pictures, without a display. All functions need a device like openOffscreen(), and throw Error.

#include <optional>
#include <string>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/coloring.h"
#include "viewer/image.h"
#include "viewer/range_strip.h"
#include "viewer/view_camera.h"

namespace scanmill {

constexpr int kLeastPictureSide = 64;
constexpr int kMostPictureSide = 8192;
// Maximum of width * height (8K); drawing takes about 28 bytes per pixel.
constexpr int kMostPicturePixels = 36'000'000;

struct PictureOptions {
  std::optional<ColorBy> colorBy{};  // absent: colorScan() chooses
  View view = View::Chase;
  int width = 1600;
  int height = 900;
  double zoom = 1;
  double pointSize = 1;    // factor of the usual diameter
  bool depthEdges = true;  // points behind a nearer surface are darkened (eye-dome lighting)
};

// Draws the scan in perspective or from above, with `title` over it and the number of points and the legend beside it.
// The picture of an empty scan says that it is empty.
Image drawPicture(const Scan& scan, const Ontology* ontology, const PictureOptions& options, const std::string& title);

// Draws the scan as drawPicture() does, in the colours of `coloring`; `options.colorBy` is ignored.
Image drawColored(const Scan& scan, const Coloring& coloring, const PictureOptions& options, const std::string& title);

// Returns the colour of a scan among scans that lie over one another; `scan`: counted from 0.
Rgb overlayColor(std::size_t scan);

// Draws a scan as a range image with one row per ring, the highest beams at the top, and one pixel per beam, see
// makeRangeStrip(). Pixels are enlarged by an integer factor until the image is readable. If several points are in the
// same pixel, the nearest is shown. Throws InputError if the scan is too large for a picture, or if it is not organised
// and has no columns ring and column.
Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title);

}  // namespace scanmill
