#pragma once

// A scan as a picture, without a display. All of it wants a device as openOffscreen() does, and throws Error.

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
constexpr int kMostPicturePixels = 36'000'000;  // 8K; drawing takes about 28 bytes for each

struct PictureOptions {
  std::optional<ColorBy> colorBy;  // absent: what colorScan() takes
  View view = View::Chase;
  int width = 1600;
  int height = 900;
  double zoom = 1;
  std::optional<CloseUp> closeUp;  // absent: everything; present: only the points that its ball holds
  double pointSize = 1;            // factor
  bool depthEdges = true;          // points behind a nearer surface are darkened (eye-dome lighting)
};

// The scan seen from outside. `title` says what it is; points and colours are named beside it. An empty scan gives a
// picture that says so; a close-up without points throws InputError that says where the nearest are.
Image drawPicture(Scan scan, const Ontology* ontology, const PictureOptions& options, const std::string& title);

// The same in colours of one's own; those of points that a close-up leaves out do not matter.
Image drawColored(Scan scan, const Coloring& coloring, const PictureOptions& options, const std::string& title);

// Scans on top of one another, each in a colour of its own; where they meet, the first is seen: how methods or settings
// differ.
struct NamedScan {
  std::string name;
  Scan scan;
};
Rgb overlayColor(std::size_t scan);  // counted from 0
Image drawOverlay(const std::vector<NamedScan>& scans, const PictureOptions& options, const std::string& title);

// The scan as its beams look: a row per ring, the highest beams on top, and a pixel per beam, see makeRangeStrip().
// Pixels are enlarged in whole steps until the image is readable. Of two points on a pixel the nearer wins.
// Throws InputError where the scan is not organised and lacks ring or column, or is too large for a picture.
Image drawRangeImage(const Scan& scan, const Ontology* ontology, const std::optional<ColorBy>& colorBy,
                     const std::string& title, StripOrder order = StripOrder::Sensor);

}  // namespace scanmill
