#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "viewer/color_map.h"
#include "viewer/legend.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

// Row and column of each point in the order of the sensor.
struct Grid {
  int rings = 1;
  int columns = 1;
  bool flipped = false;  // ring 0 is the lowest beam

  static std::size_t ring(const Scan& scan, std::size_t i) { return scan.organised ? i / scan.columns : scan.ring[i]; }
  static std::size_t column(const Scan& scan, std::size_t i) {
    return scan.organised ? i % scan.columns : scan.column[i];
  }
};

// Whether elevations rise with the ring's number: the sign of their covariance.
bool ringsRise(const Scan& scan) {
  double sumRing = 0, sumElevation = 0, sumBoth = 0, count = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    const Vec3d p(scan.position[i]);
    const double elevation = std::atan2(p.z, std::hypot(p.x, p.y));
    const auto ring = static_cast<double>(Grid::ring(scan, i));
    sumRing += ring;
    sumElevation += elevation;
    sumBoth += ring * elevation;
    count += 1;
  }
  return sumBoth * count > sumRing * sumElevation;
}

Grid gridOf(const Scan& scan) {
  std::size_t rings = scan.rings;
  std::size_t columns = scan.columns;
  if (!scan.organised) {
    for (const char* name : {"ring", "column"}) {
      const auto& column = name[0] == 'r' ? scan.ring : scan.column;
      if (column.empty() && scan.size() > 0) {
        throw InputError(
            fmt::format("the scan has no column '{}', which --range-image needs where a scan is not "
                        "organised: name it in the pipeline's output.columns",
                        name));
      }
    }
    for (const std::uint16_t r : scan.ring) rings = std::max<std::size_t>(rings, r + std::size_t{1});
    for (const std::uint16_t c : scan.column) columns = std::max<std::size_t>(columns, c + std::size_t{1});
  }
  if (rings > kMostPictureSide || columns > kMostPictureSide) {
    throw InputError(fmt::format("{} rings x {} columns do not fit a picture of at most {} x {}", rings, columns,
                                 kMostPictureSide, kMostPictureSide));
  }
  return {std::max(static_cast<int>(rings), 1), std::max(static_cast<int>(columns), 1), ringsRise(scan)};
}

Image nearestPoints(const Scan& scan, const Grid& grid, const std::vector<Rgb>& colors) {
  Image image(grid.columns, grid.rings, kBackground);
  std::vector<double> ranges(image.pixels.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double range = length(Vec3d(scan.position[i]));
    const auto ring = static_cast<int>(Grid::ring(scan, i));
    const int row = grid.flipped ? grid.rings - 1 - ring : ring;
    const std::size_t pixel =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + Grid::column(scan, i);
    if (!(range < ranges[pixel])) continue;
    ranges[pixel] = range;
    image.pixels[pixel] = colors[i];
  }
  return image;
}

Image enlarged(const Image& image, int stepX, int stepY) {
  Image out(image.width * stepX, image.height * stepY, kBackground);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) out.at(x, y) = image.at(x / stepX, y / stepY);
  }
  return out;
}

int wholeSteps(double wanted, int size) {
  return std::clamp(static_cast<int>(std::ceil(wanted / size)), 1, std::max(kMostPictureSide / size, 1));
}

}  // namespace

Image drawRangeImage(const Scan& scan, const Ontology* ontology, std::optional<ColorBy> colorBy,
                     const std::string& title) {
  constexpr double kReadableWidth = 1600;
  constexpr double kReadableShare = 1.0 / 7;  // height over width
  const Coloring coloring = colorScan(scan, colorBy, ontology);
  const Grid grid = gridOf(scan);
  const int stepX = wholeSteps(kReadableWidth, grid.columns);
  const int stepY = wholeSteps(grid.columns * stepX * kReadableShare, grid.rings);
  const Image body = enlarged(nearestPoints(scan, grid, coloring.colors), stepX, stepY);
  const PictureLayout layout = layoutAround(body.width, body.height, coloring.legend);
  Image image(layout.width, layout.height, kBackground);
  paste(image, body, 0, layout.top);
  drawTitle(image, layout, fmt::format("{}, {} rings x {} columns", title, grid.rings, grid.columns),
            fmt::format("ring 0 at the {}, {}", grid.flipped ? "bottom" : "top", coloring.legend.title));
  drawLegend(image, layout, coloring.legend);
  const bool empty =
      std::none_of(scan.position.begin(), scan.position.end(), [](const Vec3f& p) { return isFinite(p); });
  if (empty) drawNotice(image, layout, "no points");
  return image;
}

}  // namespace scanmill
