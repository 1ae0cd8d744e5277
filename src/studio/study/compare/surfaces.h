#pragma once

// Measures how rough surfaces are in range images of about 1024 columns a turn, by group of patches and band of ranges,
// and compares two sets by it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "study/compare/patches.h"

namespace scanmill {

// "Beside" means the pixels to the left and right in the ring; both must be of the class of the middle one if classes
// are compared.
inline constexpr auto kSurfaceFigures = std::to_array<ComparedFigure>({
    {"along_median", "along a ring, median", "mm", 1000, "distance of a range from the mean of the two beside",
     "effects range_noise, quantize and relief; how finely the scene's models are made"},
    {"along_75", "along a ring, 75 %", "mm", 1000, "75th percentile of this distance", "as the median"},
    {"along_90", "along a ring, 90 %", "mm", 1000, "90th percentile of this distance",
     "the scene: leaves, gaps, edges; windows (light_paths)"},
    {"beyond_half", "along a ring, above 0.5 m", "%", 100, "how often this distance is above 0.5 m",
     "the scene: leaves, gaps, edges; windows (light_paths)"},
    {"beyond_two", "along a ring, above 2 m", "%", 100, "how often this distance is above 2 m",
     "the scene: leaves, gaps, edges; windows (light_paths)"},
    {"lost", "lost neighbours", "%", 100, "how often the pixel to the right has no return",
     "effects dropout, detection and light_paths; sky beside the scene's things"},
    {"ring_to_ring", "ring to ring", "m", 1, "median difference of a range from the one above, of the same class",
     "effects ring_bias; how steep the scene's things are"},
});
inline constexpr std::size_t kSurfaceFigureCount = kSurfaceFigures.size();
using SurfaceFigures = std::array<double, kSurfaceFigureCount>;  // NaN: too few pixels

// The lower ends of the bands of ranges (m), and the end of the last.
inline constexpr std::array<double, 5> kSurfaceBands{3, 8, 15, 30, 60};

// The groups of a set's patches. Equal numbers mean the same group in both of the compared sets.
struct Groups {
  std::vector<std::uint16_t> ofPatch;                // group of each patch
  std::map<std::uint16_t, std::uint16_t> ofLabel{};  // group of each class id; empty: groups are shapes
};

// The figures of a set in one group and band of ranges.
struct Surfaces {
  SurfaceFigures figures;
  std::size_t pixels;  // number of pixels whose neighbours in the ring are of the group
};
using SurfacesByGroup = std::map<std::pair<std::uint16_t, std::size_t>, Surfaces>;  // by group and band
// Measures the surfaces of a set. Omits groups and bands with too few pixels.
SurfacesByGroup surfacesOf(const Patches& patches, const Groups& groups, bool knowsMisses);

// Figures of both sets in one band of ranges, as shown to users.
struct SurfaceComparison {
  std::string band;
  SurfaceFigures real, simulated;
  std::size_t realPixels;  // pixels of the real set

  // True if a figure can be compared: both sets have it, it is at least kLeastCounted in the real one, and a share is
  // that of several pixels there.
  bool isCounted(std::size_t figure) const;
  // True if the figures of both sets are within the factor kAlike.
  bool isAlike(std::size_t figure) const;
};

// Returns the bands in which both sets have enough pixels of a group.
std::vector<SurfaceComparison> compareSurfaces(const SurfacesByGroup& real, const SurfacesByGroup& simulated,
                                               std::uint16_t group);

// A factor between two figures, and the least figure of the real set (in the unit that users see) that is counted.
inline constexpr double kAlike = 1.5, kLeastCounted = 0.05;

}  // namespace scanmill
