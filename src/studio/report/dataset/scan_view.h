#pragma once

// Writes scans that the reader of a report's page can rotate: scan_view.js draws them with three.js.

#include <cstdint>
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

// Number of points shown per scan, at most: below 65536, so that indices take 16 bits.
inline constexpr std::size_t kMostViewedPoints = 60'000;

// Returns the JSON that scan_view.js draws, escaped for a <script> element; empty without scans: {viridis: [[r, g, b]
// ...], scans: [{title, points, shown, box: {low, step}, position, classes, class, instances, instance, values}]}.
// `position` and each column are {type, data}: base64 of little-endian "u8", "u16" or "u32", three a point for
// positions: coordinate = low + step * number (m). `class` and `instance` are indices into `classes` ({id, name, color,
// points of the complete scan}) and `instances` ({ids, colors}); `values` are further columns, {name, unit, whole, low,
// step, type, data}, in which 65535 stands for no number unless all are `whole`. Columns that the scan lacks are left
// out. A scan with more points than kMostViewedPoints is thinned by pointsToView().
std::string scanView(const std::vector<ViewedScan>& scans, const Ontology& ontology);

// The texts of files that CMake embeds in the program.
extern const std::string_view kThreeScript;      // three.js
extern const std::string_view kOrbitScript;      // the OrbitControls of three.js
extern const std::string_view kScanViewScript;   // scan_view.js
extern const std::string_view kScanViewStyle;    // scan_view.css
extern const std::string_view kDatasetTemplate;  // dataset.html
extern const std::string_view kDatasetStyle;     // dataset.css

}  // namespace scanmill
