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
  std::optional<ColorBy> colorBy;  // absent: colorScan() chooses
  View view = View::Chase;
  int width = 1600;
  int height = 900;
  double zoom = 1;
  std::optional<CloseUp> closeUp;  // only points in the close-up's ball are drawn; absent: all points
  double pointSize = 1;            // factor by which points are larger than usual
  bool depthEdges = true;          // darkens points behind nearer surfaces (eye-dome lighting)
};

// Draws a scan in perspective or from above, with `title` above it, and the number of points and the legend beside it.
// If the scan is empty, the picture says so. Throws InputError if no points are within the close-up; the message states
// where the nearest point is.
Image drawPicture(Scan scan, const Ontology* ontology, const PictureOptions& options, const std::string& title);

// Draws a scan like drawPicture(), but with the given colours. `options.colorBy` and the colours of points outside of a
// close-up are ignored.
Image drawColored(Scan scan, const Coloring& coloring, const PictureOptions& options, const std::string& title);

// A scan with its name. drawOverlay() draws several scans on top of one another, each in a separate colour, to show the
// differences between methods or settings. If points coincide, that of the first scan is visible.
struct NamedScan {
  std::string name;
  Scan scan;
};
Rgb overlayColor(std::size_t scan);  // returns the colour of the scan with this index
Image drawOverlay(const std::vector<NamedScan>& scans, const PictureOptions& options, const std::string& title);

// Draws a scan as a range image with one row per ring, the highest beams at the top, and one pixel per beam, see
// makeRangeStrip(). Pixels are enlarged by an integer factor until the image is readable. If several points are in the
// same pixel, the nearest is shown. Throws InputError if the scan is too large for a picture, or if it is not organised
// and has no columns ring and column.
Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title, StripOrder order = StripOrder::Sensor);

}  // namespace scanmill
