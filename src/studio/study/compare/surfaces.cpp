#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "evaluate/spread.h"
#include "study/compare/compare.h"

namespace scanmill {

namespace {

// The pixels of a group in a band: distances (m) along the ring and to the ring above; 1 for each pixel with a lost
// neighbour, 0 for the others.
struct SurfacePixels {
  std::vector<float> along, above, lost;
};

double shareBeyond(const std::vector<float>& distances, float limit) {
  const auto isBeyond = [&](float distance) { return distance > limit; };
  return shareOf(static_cast<std::uint64_t>(std::ranges::count_if(distances, isBeyond)), distances.size());
}

}  // namespace

SurfacesByGroup surfacesOf(const Patches& patches, const Groups& groups, bool knowsMisses) {
  std::map<std::pair<std::uint16_t, std::size_t>, SurfacePixels> cells;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const PixelNeighbours& beside = patches.beside[i];
    const float range = patches.range[i];
    if (!beside.isPixel || !(range >= kSurfaceBands.front()) || !(range < kSurfaceBands.back())) continue;
    const auto band =
        static_cast<std::size_t>(std::ranges::upper_bound(kSurfaceBands, range) - kSurfaceBands.begin()) - 1;
    const std::uint16_t group = groups.ofPatch[i];
    const auto isAlike = [&](std::size_t neighbour) {
      if (std::isnan(beside.range[neighbour])) return false;
      const auto found = groups.ofLabel.find(beside.label[neighbour]);
      return groups.ofLabel.empty() || (found != groups.ofLabel.end() && found->second == group);
    };
    SurfacePixels& pixels = cells[{group, band}];
    if (isAlike(PixelNeighbours::kLeft) && isAlike(PixelNeighbours::kRight)) {
      const float sum = beside.range[PixelNeighbours::kLeft] + beside.range[PixelNeighbours::kRight];
      pixels.along.push_back(std::fabs(range - sum / 2));
    }
    if (isAlike(PixelNeighbours::kAbove)) {
      pixels.above.push_back(std::fabs(range - beside.range[PixelNeighbours::kAbove]));
    }
    if (knowsMisses) pixels.lost.push_back(std::isnan(beside.range[PixelNeighbours::kRight]) ? 1.0f : 0.0f);
  }
  constexpr std::size_t kFewestPixels = 50;
  SurfacesByGroup figures;
  for (const auto& [cell, pixels] : cells) {
    if (std::min(pixels.along.size(), pixels.above.size()) < kFewestPixels) continue;
    figures[cell] = {{quantileOf(pixels.along, 0.5), quantileOf(pixels.along, 0.75), quantileOf(pixels.along, 0.9),
                      shareBeyond(pixels.along, 0.5), shareBeyond(pixels.along, 2), meanOf(pixels.lost),
                      quantileOf(pixels.above, 0.5)},
                     pixels.along.size()};
    for (std::size_t f = 0; f < kSurfaceFigureCount; ++f) figures[cell].figures[f] *= kSurfaceFigures[f].factor;
  }
  return figures;
}

std::vector<SurfaceComparison> compareSurfaces(const SurfacesByGroup& real, const SurfacesByGroup& simulated,
                                               std::uint16_t group) {
  std::vector<SurfaceComparison> bands;
  for (std::size_t band = 0; band + 1 < kSurfaceBands.size(); ++band) {
    const auto ofReal = real.find({group, band}), ofSimulated = simulated.find({group, band});
    if (ofReal == real.end() || ofSimulated == simulated.end()) continue;
    bands.push_back({fmt::format("{:g} to {:g} m", kSurfaceBands[band], kSurfaceBands[band + 1]),
                     ofReal->second.figures, ofSimulated->second.figures, ofReal->second.pixels});
  }
  return bands;
}

bool SurfaceComparison::isCounted(std::size_t figure) const {
  constexpr double kFewestInShare = 10;  // pixels
  const bool isShare = kSurfaceFigures[figure].unit == "%";
  const double share = real[figure] / kSurfaceFigures[figure].factor;
  return real[figure] >= kLeastCounted && !std::isnan(simulated[figure]) &&
         (!isShare || share * static_cast<double>(realPixels) >= kFewestInShare);
}

bool SurfaceComparison::isAlike(std::size_t figure) const {
  return real[figure] <= simulated[figure] * kAlike && simulated[figure] <= real[figure] * kAlike;
}

}  // namespace scanmill
