#pragma once

// Writes scans for a report's 3D view, in which users can rotate them. scan_view.js draws the view with three.js.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"

namespace scanmill {

struct ViewedScan {
  std::string title;
  Scan scan;
};

// Maximum number of points that are shown per scan. It is below 65536, so that indices fit into 16 bits.
inline constexpr std::size_t kMostViewedPoints = 60'000;

// Returns the JSON that scan_view.js draws, escaped for a <script> element; empty if there are no scans. Its structure
// is {viridis: [[r, g, b] ...], background: [r, g, b], none: [r, g, b], scans: [{title, points, shown, box: {low,
// step}, position, classes, class, instances, instance, values}]}. `position` and each column are {type, data}: base64
// of little-endian "u8", "u16" or "u32" numbers. A position consists of three numbers, coordinate = low + step * number
// (m). `class` and `instance` are indices in the lists `classes`, {id, name, color, points in the complete scan}, and
// `instances`, {ids, colors}. `values` are further columns, {name, unit, whole, low, step, type, data}; if `whole` is
// false, 65535 means that there is no value. Columns that a scan does not have are omitted. Scans with more than
// kMostViewedPoints points are thinned by pointsToView().
std::string scanView(const std::vector<ViewedScan>& scans, const Ontology& ontology);

// Contents of files that CMake embeds in the program:
extern const std::string_view kThreeScript;      // three.js
extern const std::string_view kOrbitScript;      // OrbitControls of three.js
extern const std::string_view kScanViewScript;   // scan_view.js
extern const std::string_view kScanViewStyle;    // scan_view.css
extern const std::string_view kDatasetTemplate;  // dataset.html
extern const std::string_view kDatasetStyle;     // dataset.css

// Returns the indices, ascending, of the finite points to show: all if they are at most `most`, otherwise `most` of
// them. Instances and classes with few points are kept complete, the smallest first, as long as they take at most half
// of `most`. The other points are thinned evenly along the scan; the fraction kept is proportional to the squared
// distance, with which the density of points on a surface decreases. Mainly near surfaces lose points.
std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most);

}  // namespace scanmill
