#include "study/compare/patches.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace scanmill {

namespace {

constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t kFewestInPatch = 12;  // least number of points to which a plane is fitted
constexpr double kPlanar = 0.35;            // thickness divided by width, below which a patch counts as a plane
constexpr double kLevel = 25;               // angle to the horizontal (degrees) below which a plane counts as level
constexpr double kUpright = 65;             // angle to the horizontal (degrees) above which a plane counts as upright
// Cosine of 60 degrees; Patches::ringOffset is not measured at larger incidence angles.
constexpr double kLeastCosine = 0.5;
// Points are on one surface if their ranges differ by less than kNear (m) or than the range times kNearShare.
constexpr double kNear = 0.5, kNearShare = 0.1;

// Measures patches one after the other. addPatch() first stores the patch's pixel, range and window in members, and
// appends NaN to the lists in `out_`. The functions that measure features then replace the last entry of their list.
class PatchMeter {
 public:
  PatchMeter(const Scan& scan, const RangeGrid& grid, Patches& out)
      : scan_(scan),
        grid_(grid),
        out_(out),
        beamsPerPixel_(grid.wraps ? std::max(1, static_cast<int>(std::lround(grid.columns / 1024.0))) : 1) {}

  // Appends the patch around a pixel with a return.
  void addPatch(std::uint32_t row, std::uint32_t column) {
    pixel_ = grid_.at(row, column);
    range_ = grid_.range[pixel_];
    const Vec3d middle(scan_.position[grid_.point[pixel_]]);
    for (std::vector<float>& values : out_.value) values.push_back(kNotMeasured);
    out_.ringGain.push_back(kNotMeasured);
    out_.ringOffset.push_back(kNotMeasured);
    out_.range.push_back(static_cast<float>(range_));
    out_.row.push_back(static_cast<std::uint16_t>(row));
    out_.label.push_back(labelOf(pixel_));
    addNeighbours(row, column);
    gatherWindow(row, column);
    addShape(middle);
    addMixed();
    addRangeScatter();
    addRingOffset(middle);
    if (!scan_[kIntensity].empty()) addIntensity();
    if (grid_.knowsMisses) addMisses();
    set(Feature::Returns, grid_.returns[pixel_]);
  }

 private:
  void set(Feature feature, double value) const { out_.of(feature).back() = static_cast<float>(value); }

  bool hasReturn(std::uint32_t pixel) const {
    return pixel != RangeGrid::kNone && grid_.point[pixel] != RangeGrid::kNone;
  }
  // True if the pixel has a return with nearly the range of the patch's middle, so that both are on one surface.
  bool onSurface(std::uint32_t pixel) const {
    return hasReturn(pixel) &&
           std::fabs(static_cast<double>(grid_.range[pixel]) - range_) < std::max(kNear, kNearShare * range_);
  }
  std::uint16_t labelOf(std::size_t pixel) const {
    return scan_[kLabel].empty() ? std::uint16_t{0} : scan_[kLabel][grid_.point[pixel]];
  }
  Vec3d pointAt(std::uint32_t pixel) const { return Vec3d(scan_.position[grid_.point[pixel]]); }

  // Returns the nearest return of a pixel of the coarser range image (see PixelNeighbours); kNone if there is none.
  // `first`: the first of the pixel's columns in the grid. `steps`: number of pixels to the right of this.
  std::uint32_t nearestIn(std::uint32_t row, std::uint32_t first, int steps) const {
    std::uint32_t nearest = RangeGrid::kNone;
    for (int k = 0; k < beamsPerPixel_; ++k) {
      const std::uint32_t pixel = grid_.beside(row, first, steps * beamsPerPixel_ + k);
      if (!hasReturn(pixel)) continue;
      if (nearest == RangeGrid::kNone || grid_.range[pixel] < grid_.range[nearest]) nearest = pixel;
    }
    return nearest;
  }

  void addNeighbours(std::uint32_t row, std::uint32_t column) {
    const std::uint32_t first = column - column % static_cast<std::uint32_t>(beamsPerPixel_);
    PixelNeighbours& beside = out_.beside.emplace_back();
    beside.isPixel = nearestIn(row, first, 0) == pixel_;
    const std::array<std::uint32_t, PixelNeighbours::kCount> neighbours{
        nearestIn(row, first, -1), nearestIn(row, first, 1), row > 0 ? nearestIn(row - 1, first, 0) : RangeGrid::kNone};
    for (std::size_t i = 0; i < PixelNeighbours::kCount; ++i) {
      const bool exists = neighbours[i] != RangeGrid::kNone;
      beside.range[i] = exists ? grid_.range[neighbours[i]] : kNotMeasured;
      beside.label[i] = exists ? labelOf(neighbours[i]) : std::uint16_t{0};
    }
  }

  // Stores the pixels of the window around the patch's point, row by row; kNone for pixels beyond the grid's edges.
  void gatherWindow(std::uint32_t middleRow, std::uint32_t column) {
    for (int dr = -kPatchRowReach; dr <= kPatchRowReach; ++dr) {
      for (int dc = -kPatchReach; dc <= kPatchReach; ++dc) {
        const std::int64_t row = std::int64_t{middleRow} + dr;
        window_[indexOf(dr, dc)] =
            row < 0 || row >= grid_.rows ? RangeGrid::kNone : grid_.beside(static_cast<std::uint32_t>(row), column, dc);
      }
    }
  }
  static std::size_t indexOf(int dr, int dc) {
    return static_cast<std::size_t>(dr + kPatchRowReach) * std::size_t{kWide} +
           static_cast<std::size_t>(dc + kPatchReach);
  }
  // Returns the pixel `dr` rows below and `dc` columns right of the patch's middle; kNone beyond the grid's edges.
  std::uint32_t pixelAt(int dr, int dc) const { return window_[indexOf(dr, dc)]; }

  // Fits a plane to the window's points on the surface; sets the patch's kind, incidence, thicknesses and steepness.
  void addShape(const Vec3d& middle) {
    points_.clear();
    for (const std::uint32_t pixel : window_) {
      if (onSurface(pixel)) points_.push_back(pointAt(pixel));
    }
    out_.kind.push_back(PatchKind::Sparse);
    out_.incidence.push_back(kNotMeasured);
    if (points_.size() < kFewestInPatch) return;
    const Plane plane = planeOf(points_);
    if (!(plane.width > 0)) return;
    const double steepness = degrees(std::acos(std::min(1.0, std::fabs(plane.normal.z))));
    set(Feature::Thickness, plane.thickness);
    set(Feature::RelativeThickness, plane.thickness / plane.width);
    set(Feature::Steepness, steepness);
    out_.incidence.back() =
        static_cast<float>(std::acos(std::min(1.0, std::fabs(dot(plane.normal, middle)) / length(middle))));
    const bool flat = plane.thickness < kPlanar * plane.width;
    out_.kind.back() = !flat                  ? PatchKind::Rough
                       : steepness < kLevel   ? PatchKind::Level
                       : steepness > kUpright ? PatchKind::Upright
                                              : PatchKind::Slanted;
  }

  // Returns the range (m) of the beam `dc` columns beside the patch's middle; NaN if the beam has no return.
  double rangeAt(int dc) const {
    const std::uint32_t pixel = pixelAt(0, dc);
    return hasReturn(pixel) ? static_cast<double>(grid_.range[pixel]) : std::numeric_limits<double>::quiet_NaN();
  }
  // True if the beams from `first` to `last` (columns from the patch's middle) have known ranges without a jump.
  bool isSmooth(int first, int last) const {
    for (int dc = first; dc < last; ++dc) {
      if (!(std::fabs(rangeAt(dc + 1) - rangeAt(dc)) < kJump)) return false;
    }
    return true;
  }

  // Sets Feature::Mixed if the middle's range is between the ranges of its neighbours in the row: the smaller
  // difference from either, as a fraction of the step. Ignores small steps, and sides that are not smooth, such as
  // foliage.
  void addMixed() const {
    const double edge = std::fabs(rangeAt(1) - rangeAt(-1));
    if (!(edge >= kEdge) || !isSmooth(-2, -1) || !isSmooth(1, 2)) return;
    const double nearer = std::fmin(rangeAt(-1), rangeAt(1));
    if (range_ < nearer || range_ > nearer + edge) return;
    const double fromNearer = (range_ - nearer) / edge;
    set(Feature::Mixed, std::min(fromNearer, 1 - fromNearer));
  }

  // Sets Feature::RangeScatter: the ranges' deviation from a parabola fitted over seven columns. The fit uses
  // polynomials orthogonal over the columns k from -3 to 3: 1, k and k^2 - 4. Their sums of squares are 7, 28 and 84.
  void addRangeScatter() const {
    constexpr int kFit = 3;
    if (!isSmooth(-kFit, kFit)) return;
    double mean = 0, slope = 0, curvature = 0;
    for (int k = -kFit; k <= kFit; ++k) {
      const double r = rangeAt(k) - range_;
      mean += r / 7;
      slope += r * k / 28;
      curvature += r * (k * k - 4) / 84;
    }
    double squares = 0;
    for (int k = -kFit; k <= kFit; ++k) {
      const double residual = rangeAt(k) - range_ - mean - slope * k - curvature * (k * k - 4);
      squares += residual * residual;
    }
    set(Feature::RangeScatter, std::sqrt(squares / 4));  // 4 degrees of freedom: 7 ranges, 3 coefficients
  }

  // Measures the mean distance of the middle ring's points from the plane of the rings above and below. Sets
  // Feature::RingOffset to the absolute distance along the plane's normal, and Patches::ringOffset to the distance
  // along the beam, positive if the points are behind the plane.
  void addRingOffset(const Vec3d& middle) {
    if (!grid_.knowsRings) return;
    constexpr int kMeasuredReach = 2;  // columns on each side of the middle whose points are measured
    constexpr std::size_t kFewestMeasured = 4, kFewestInRing = 5;
    points_.clear();
    for (const int dr : {-1, 1}) {
      const std::size_t before = points_.size();
      for (int dc = -kPatchReach; dc <= kPatchReach; ++dc) {
        if (onSurface(pixelAt(dr, dc))) points_.push_back(pointAt(pixelAt(dr, dc)));
      }
      if (points_.size() - before < kFewestInRing) return;
    }
    const Plane plane = planeOf(points_);
    if (!(plane.width > 0) || plane.thickness >= kPlanar * plane.width) return;
    double sum = 0;
    std::size_t count = 0;
    for (int dc = -kMeasuredReach; dc <= kMeasuredReach; ++dc) {
      if (!onSurface(pixelAt(0, dc))) continue;
      sum += plane.distanceOf(pointAt(pixelAt(0, dc)));
      ++count;
    }
    if (count < kFewestMeasured) return;
    const double outwards = dot(plane.normal, middle) < 0 ? -1 : 1;
    const double offset = outwards * sum / static_cast<double>(count);
    const double cosine = std::fabs(dot(plane.normal, middle)) / length(middle);  // cosine of the incidence angle
    if (cosine > kLeastCosine) out_.ringOffset.back() = static_cast<float>(offset / cosine);
    set(Feature::RingOffset, std::fabs(offset));
  }

  // Returns the mean intensity of the returns on the surface, `dr` rows below the patch's middle and at the column
  // offsets `columns`; nothing if there are fewer than four of these returns, or if all their intensities are 0.
  std::optional<double> meanIntensity(int dr, std::initializer_list<int> columns) const {
    double sum = 0;
    int count = 0;
    for (const int dc : columns) {
      if (!onSurface(pixelAt(dr, dc))) continue;
      sum += static_cast<double>(scan_[kIntensity][grid_.point[pixelAt(dr, dc)]]);
      ++count;
    }
    if (count < 4 || !(sum > 0)) return {};
    return sum / count;
  }

  // Sets the intensity, its scatter relative to four neighbours in the ring, and its gain relative to adjacent rings.
  void addIntensity() const {
    const double intensity = static_cast<double>(scan_[kIntensity][grid_.point[pixel_]]);
    set(Feature::Intensity, intensity);
    if (const auto beside = meanIntensity(0, {-2, -1, 1, 2})) {
      set(Feature::IntensityScatter, std::fabs(intensity / *beside - 1));
    }
    if (!grid_.knowsRings) return;
    const auto columns = {-2, -1, 0, 1, 2};
    const auto middle = meanIntensity(0, columns);
    const auto above = meanIntensity(-1, columns), below = meanIntensity(1, columns);
    if (!middle || !above || !below) return;
    out_.ringGain.back() = static_cast<float>(std::log(*middle / (0.5 * (*above + *below))));
    set(Feature::RingGain, std::fabs(static_cast<double>(out_.ringGain.back())));
  }

  // Sets the fraction of the window's beams without a return, and the fraction of the middle row's beams that have no
  // return although both neighbours have returns at about the same range.
  void addMisses() const {
    const auto beams = std::ranges::count_if(window_, [](std::uint32_t pixel) { return pixel != RangeGrid::kNone; });
    const auto returns = std::ranges::count_if(window_, [&](std::uint32_t pixel) { return hasReturn(pixel); });
    set(Feature::Missing, static_cast<double>(beams - returns) / static_cast<double>(beams));
    int single = 0;
    constexpr int kAround = kPatchReach - 1;
    for (int dc = -kAround; dc <= kAround; ++dc) {
      if (pixelAt(0, dc) == RangeGrid::kNone || hasReturn(pixelAt(0, dc)) || !hasReturn(pixelAt(0, dc - 1)) ||
          !hasReturn(pixelAt(0, dc + 1)))
        continue;
      single += std::fabs(grid_.range[pixelAt(0, dc - 1)] - grid_.range[pixelAt(0, dc + 1)]) < static_cast<float>(kJump)
                    ? 1
                    : 0;
    }
    set(Feature::SingleMissing, single / (2.0 * kAround + 1));
  }

  static constexpr int kWide = 2 * kPatchReach + 1;
  static constexpr std::size_t kWindow = static_cast<std::size_t>(kWide) * (2 * kPatchRowReach + 1);

  const Scan& scan_;
  const RangeGrid& grid_;
  Patches& out_;
  int beamsPerPixel_;  // columns of the grid in a pixel of the coarser range image, see PixelNeighbours
  // The patch that addPatch() appends: pixel and range (m) of the middle, and pixels around the middle.
  std::size_t pixel_ = 0;
  double range_ = 0;
  std::array<std::uint32_t, kWindow> window_{};  // see gatherWindow()
  std::vector<Vec3d> points_;                    // memory that is used again for each patch
};

}  // namespace

Plane planeOf(std::span<const Vec3d> points) {
  Plane plane;
  for (const Vec3d& p : points) plane.middle += p;
  const auto count = static_cast<double>(points.size());
  plane.middle = plane.middle * (1 / count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();  // sum of the outer products of p - middle
  for (const Vec3d& p : points) {
    const Vec3d d = p - plane.middle;
    const Eigen::Vector3d v(d.x, d.y, d.z);
    scatter += v * v.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter / count);  // eigenvalues ascend
  const auto deviation = [&](int i) { return std::sqrt(std::max(0.0, solver.eigenvalues()[i])); };
  plane.thickness = deviation(0);
  plane.width = deviation(1);
  const Eigen::Vector3d n = solver.eigenvectors().col(0);
  plane.normal = Vec3d{n.x(), n.y(), n.z()} * (n.z() < 0 ? -1 : 1);
  return plane;
}

void Patches::append(const Patches& more) {
  const auto add = [](auto& list, const auto& added) { list.insert(list.end(), added.begin(), added.end()); };
  for (std::size_t f = 0; f < kFeatureCount; ++f) add(value[f], more.value[f]);
  add(range, more.range);
  add(incidence, more.incidence);
  add(ringOffset, more.ringOffset);
  add(ringGain, more.ringGain);
  add(row, more.row);
  add(label, more.label);
  add(kind, more.kind);
  add(beside, more.beside);
  add(scan, more.scan);
}

Patches patchesOf(const Scan& scan, const RangeGrid& grid, std::uint32_t scanIndex) {
  constexpr std::size_t kMostPatches = 20'000;
  std::vector<std::size_t> pixels;  // pixels with a return
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (grid.point[i] != RangeGrid::kNone) pixels.push_back(i);
  }
  Patches patches;
  PatchMeter meter(scan, grid, patches);
  const std::size_t count = std::min(kMostPatches, pixels.size());
  patches.scan.assign(count, scanIndex);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t pixel = pixels[k * pixels.size() / count];
    meter.addPatch(static_cast<std::uint32_t>(pixel / grid.columns), static_cast<std::uint32_t>(pixel % grid.columns));
  }
  return patches;
}

}  // namespace scanmill
