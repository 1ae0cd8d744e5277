// Layout `auto` has side cameras that share the azimuths evenly and, if beams are steep, cameras that look up or down.
// Each image covers only the part of its camera's plane that its beams need, so that the principal point may be outside
// of the image. All cameras have the same focal length; of several candidate layouts the one with the lowest cost is
// chosen. The cost counts pixels and images.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "methods/depth_camera/depth_camera.h"

namespace scanmill {

namespace {

constexpr double kImageCost = 100'000;              // number of pixels that cost as much as one more image
constexpr double kWidestField = radians(168.0);     // largest field of view; a wider image has most pixels at its edge
constexpr int kMostSides = 6;                       // largest number of side cameras; up to two more look up or down
constexpr double kSteepest = 1e4;                   // slope z / sqrt(x^2 + y^2) to which steeper slopes are limited
constexpr double kSmallestDepth = 1e-4;             // a unit direction with less depth along the camera's axis is
                                                    // outside of the image
constexpr int kBins = 512;                          // number of bins of azimuth by which the cameras are chosen
constexpr double kFullRevolution = radians(300.0);  // a wider range of azimuths is treated as a full circle

// Returns a number from 0 to 4 that increases with the azimuth of (x, y), without trigonometry: the length of the path
// along the square |x| + |y| = 1, in units of the square's side.
double squareAngle(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (!(sum > 0)) return 0;
  const double p = y / sum;
  if (x < 0) return 2 - p;
  return y < 0 ? 4 + p : p;
}

double squareAngle(double azimuth) {
  return squareAngle(std::cos(azimuth), std::sin(azimuth));
}

// Returns the azimuth (rad) for which squareAngle() returns `square`.
double azimuthOf(double square) {
  const double p = std::fmod(square + 4, 4.0);
  if (p < 1) return std::atan2(p, 1 - p);
  if (p < 3) return std::atan2(2 - p, p < 2 ? 1 - p : p - 3);
  return std::atan2(p - 4, p - 3);
}

// Returns the rotation sensorFromCamera of a camera that looks in this direction (rad; a positive pitch looks down).
Quat facing(double yaw, double pitch) {
  return fromYawPitchRoll(yaw, pitch, 0) * vehicleFromOptical();
}

// The part of a camera's plane (at depth 1) that contains the projections of the camera's beams.
struct Window {
  Mat3 axes;  // columns: right, down, forward
  double left = INFINITY;
  double right = -INFINITY;
  double top = INFINITY;
  double bottom = -INFINITY;
  bool outside = false;  // true if some direction cannot be projected onto the plane

  explicit Window(const Quat& sensorFromCamera) : axes(toMatrix(sensorFromCamera)) {}

  // Extends the window to the projection of a direction.
  void add(const Vec3d& direction) {
    const double depth = dot(axes.z, direction);
    if (!(depth > kSmallestDepth)) {
      outside = true;
      return;
    }
    const double x = dot(axes.x, direction) / depth;
    const double y = dot(axes.y, direction) / depth;
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  bool empty() const { return !(left <= right); }
  // Returns true if one image can show all directions.
  bool fitsAnImage() const {
    return !outside && std::atan(right) - std::atan(left) < kWidestField &&
           std::atan(bottom) - std::atan(top) < kWidestField;
  }
};

// The azimuths and slopes of all beams, which suffice to choose the cameras.
struct Spread {
  std::array<double, kBins> low;   // least slope z / sqrt(x^2 + y^2) per bin; low > high in a bin without beams
  std::array<double, kBins> high;  // largest slope per bin of squareAngle()
  double firstAzimuth = 0;         // rad, the azimuths are from firstAzimuth to firstAzimuth + width
  double width = 2 * kPi;
  double lowest = INFINITY;  // least slope of all beams
  double highest = -INFINITY;

  explicit Spread(std::span<const Vec3d> directions) {
    low.fill(INFINITY);
    high.fill(-INFINITY);
    for (const Vec3d& d : directions) {
      constexpr double kNotZero = 1e-12;  // in place of zero for vertical beams
      const double horizontal = std::sqrt(d.x * d.x + d.y * d.y);
      const double slope = std::clamp(d.z / std::max(horizontal, kNotZero), -kSteepest, kSteepest);
      const auto bin =
          std::min(static_cast<std::size_t>(squareAngle(d.x, d.y) * (kBins / 4.0)), std::size_t{kBins - 1});
      low[bin] = std::min(low[bin], slope);
      high[bin] = std::max(high[bin], slope);
      lowest = std::min(lowest, slope);
      highest = std::max(highest, slope);
    }
    findSector();
  }

  // Returns the azimuth (rad) at which a bin begins.
  static double edge(int bin) { return azimuthOf(bin * (4.0 / kBins)); }

  // Returns representative directions whose projections bound the projections of all beams: each bin is split at the
  // slopes -steep and steep, and the directions are the corners of the bin's parts in azimuth and slope.
  std::vector<Vec3d> corners(double steep) const {
    std::vector<Vec3d> directions;
    const double steeper = steep * (1 + 1e-9);  // so that these directions certainly count as steep
    for (int bin = 0; bin < kBins; ++bin) {
      const auto b = static_cast<std::size_t>(bin);
      const std::pair<double, double> slopeRanges[] = {{low[b], std::min(high[b], -steeper)},
                                                       {std::max(low[b], -steep), std::min(high[b], steep)},
                                                       {std::max(low[b], steeper), high[b]}};
      for (const auto& [least, most] : slopeRanges) {
        if (least > most) continue;
        for (const double azimuth : {edge(bin), edge(bin + 1)}) {
          for (const double slope : {least, most}) {
            directions.push_back(normalized(Vec3d{std::cos(azimuth), std::sin(azimuth), slope}));
          }
        }
      }
    }
    return directions;
  }

 private:
  // Sets `firstAzimuth` and `width` to the sector with beams: the circle without its longest sequence of empty bins.
  // The loop visits each bin twice, so that it also finds a sequence that goes on from the last bin to the first bin.
  void findSector() {
    int longest = 0;
    int endOfLongest = 0;
    int emptyBins = 0;  // number of empty bins up to bin i
    for (int i = 0; i < 2 * kBins; ++i) {
      const auto b = static_cast<std::size_t>(i % kBins);
      emptyBins = low[b] > high[b] ? emptyBins + 1 : 0;
      if (emptyBins > longest && emptyBins < kBins) {
        longest = emptyBins;
        endOfLongest = i + 1;
      }
    }
    if (longest == 0) return;
    const double sectorBegin = edge(endOfLongest % kBins);
    double sectorWidth = edge((endOfLongest - longest + kBins) % kBins) - sectorBegin;
    while (sectorWidth <= 0) sectorWidth += 2 * kPi;
    if (sectorWidth >= kFullRevolution) return;
    firstAzimuth = sectorBegin;
    width = sectorWidth;
  }
};

// A candidate layout: `sides` cameras that look sideways, one that looks up and one that looks down. See cameraOf().
class Candidate {
 public:
  // Beams with a slope of more than `steep` upwards or downwards belong to the camera that looks up or down. `pitch`:
  // angle by which the side cameras look down (rad).
  Candidate(const Spread& spread, int sides, double steep, double pitch) : sides_(sides), steep_(steep) {
    const double sector = spread.width / sides;
    // If the beams cover a full circle, camera 0 looks forward.
    const double firstAzimuth = spread.width < 2 * kPi ? spread.firstAzimuth : -sector / 2;
    origin_ = squareAngle(firstAzimuth);
    for (int i = 0; i < sides; ++i) {
      addCamera(fmt::format("side{}", i), firstAzimuth + (i + 0.5) * sector, pitch);
      if (i > 0) bounds_.push_back(fromOrigin(squareAngle(firstAzimuth + i * sector)));
    }
    addCamera("up", 0, -kPi / 2);
    addCamera("down", 0, kPi / 2);
  }

  // Returns the window of each camera around its directions. `directions`: either all beams, or Spread::corners().
  std::vector<Window> windows(std::span<const Vec3d> directions) const {
    std::vector<Window> windows;
    for (const Camera& camera : cameras_) windows.emplace_back(camera.worldFromCamera.rotation);
    for (const Vec3d& d : directions) windows[cameraOf(d)].add(d);
    return windows;
  }

  // Returns the number of pixels plus kImageCost per image, or infinity if an image would be too wide. `focal`: px.
  static double cost(const std::vector<Window>& windows, double focal) {
    constexpr double kMargins = 3;  // px along each axis: a margin of one pixel on both sides, and rounding up
    double cost = 0;
    for (const Window& w : windows) {
      if (w.empty() && !w.outside) continue;
      if (!w.fitsAnImage()) return INFINITY;
      cost += kImageCost + ((w.right - w.left) * focal + kMargins) * ((w.bottom - w.top) * focal + kMargins);
    }
    return cost;
  }

  const std::vector<Camera>& cameras() const { return cameras_; }

 private:
  void addCamera(std::string name, double yaw, double pitch) {
    cameras_.emplace_back().name = std::move(name);
    cameras_.back().worldFromCamera.rotation = facing(yaw, pitch);
  }

  // Returns `square`, a result of squareAngle(), relative to origin_, from 0 to 4.
  double fromOrigin(double square) const { return square < origin_ ? square - origin_ + 4 : square - origin_; }

  // Returns the index of the camera that a direction belongs to.
  std::size_t cameraOf(const Vec3d& d) const {
    if (std::abs(d.z) > steep_ * std::sqrt(d.x * d.x + d.y * d.y)) {
      return static_cast<std::size_t>(d.z > 0 ? sides_ : sides_ + 1);
    }
    const double angle = fromOrigin(squareAngle(d.x, d.y));
    std::size_t side = 0;
    while (side < bounds_.size() && angle >= bounds_[side]) ++side;
    return side;
  }

  int sides_;
  double steep_;
  double origin_ = 0;           // square angle of the first side camera's first azimuth
  std::vector<double> bounds_;  // values of fromOrigin() at the borders between neighbouring side cameras
  std::vector<Camera> cameras_;
};

// Returns the candidate with the lowest Candidate::cost(). `focal`: focal length (px).
Candidate cheapestCandidate(const Spread& spread, double focal) {
  const double steepest = std::max(std::abs(spread.lowest), std::abs(spread.highest));
  const double pitchToMiddle = -(std::atan(spread.lowest) + std::atan(spread.highest)) / 2;
  std::optional<Candidate> best;
  double bestCost = INFINITY;
  // Beams with an absolute elevation above this limit (deg) belong to the cameras that look up or down.
  for (const double steepElevation : {90.0, 35.0, 45.0, 55.0, 65.0}) {
    const bool hasSidesOnly = steepElevation == 90;
    const double steep = hasSidesOnly ? 2 * kSteepest : std::tan(radians(steepElevation));
    if (!hasSidesOnly && steepest <= steep) continue;  // no beam is steeper, so the result is the same as for 90
    const std::vector<Vec3d> corners = spread.corners(steep);
    const auto consider = [&](const Candidate& candidate) {
      const double cost = Candidate::cost(candidate.windows(corners), focal);
      if (cost < bestCost) {
        bestCost = cost;
        best = candidate;
      }
    };
    if (hasSidesOnly) consider(Candidate(spread, 1, steep, pitchToMiddle));
    for (int sides = 1; sides <= kMostSides; ++sides) consider(Candidate(spread, sides, steep, 0));
  }
  return best ? *best : Candidate(spread, 4, 1, 0);  // a cube covers all directions
}

std::vector<Camera> layOutAuto(std::span<const Vec3d> directions, std::uint32_t resolution) {
  const double focal = resolution / 2.0;  // px, the focal length of a square image of 90 degrees
  const Candidate candidate = cheapestCandidate(Spread(directions), focal);
  const std::vector<Window> windows = candidate.windows(directions);
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const Window& w = windows[i];
    if (w.empty()) continue;
    Camera camera = candidate.cameras()[i];
    const double left = std::floor(w.left * focal) - 1;  // px; with a margin of one pixel on each side
    const double top = std::floor(w.top * focal) - 1;
    camera.width = static_cast<std::uint32_t>(std::ceil(w.right * focal) + 1 - left);
    camera.height = static_cast<std::uint32_t>(std::ceil(w.bottom * focal) + 1 - top);
    camera.fx = camera.fy = focal;
    camera.cx = -left;
    camera.cy = -top;
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

struct NamedFacing {
  double yawDeg;
  double pitchDeg;  // deg, positive downwards
  const char* name;
};

// Assigns each direction to the camera with the nearest axis among the cameras that see the direction. Returns the
// cameras that have at least one direction.
std::vector<Camera> layOutFixed(std::span<const Vec3d> directions, std::uint32_t resolution, double fieldDeg,
                                std::span<const NamedFacing> facings) {
  std::vector<Camera> cameras;
  std::vector<Mat3> axes;
  for (const NamedFacing& f : facings) {
    Camera& camera = cameras.emplace_back(squareCamera(resolution, resolution, radians(fieldDeg)));
    camera.name = f.name;
    camera.worldFromCamera.rotation = facing(radians(f.yawDeg), radians(f.pitchDeg));
    axes.push_back(toMatrix(camera.worldFromCamera.rotation));
  }
  const double edge = std::tan(radians(fieldDeg / 2)) * (1 + 1e-9);  // at depth 1, with a margin for rounding
  std::vector<bool> isUsed(cameras.size());
  for (const Vec3d& d : directions) {
    double largestDepth = 0;  // the camera with the nearest axis is the one with the largest depth
    std::optional<std::size_t> nearest;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const double depth = dot(axes[i].z, d);
      const bool inside = std::abs(dot(axes[i].x, d)) <= edge * depth && std::abs(dot(axes[i].y, d)) <= edge * depth;
      if (inside && depth > largestDepth) {
        largestDepth = depth;
        nearest = i;
      }
    }
    if (nearest) isUsed[*nearest] = true;
  }
  std::vector<Camera> usedCameras;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (isUsed[i]) usedCameras.push_back(std::move(cameras[i]));
  }
  return usedCameras;
}

}  // namespace

std::vector<Camera> layOutCameras(std::span<const Vec3d> directions, const LayoutOptions& options) {
  if (directions.empty()) return {};
  constexpr NamedFacing kThree[] = {{0, 0, "front"}, {120, 0, "left"}, {240, 0, "right"}};
  constexpr NamedFacing kFaces[] = {{0, 0, "front"},   {90, 0, "left"}, {180, 0, "back"},
                                    {270, 0, "right"}, {0, -90, "up"},  {0, 90, "down"}};
  switch (options.layout) {
    case CameraLayout::Three120:
      return layOutFixed(directions, options.resolution, 120, kThree);
    case CameraLayout::Four90:
      return layOutFixed(directions, options.resolution, 90, std::span(kFaces).first(4));
    case CameraLayout::Cube6:
      return layOutFixed(directions, options.resolution, 90, kFaces);
    case CameraLayout::Auto:
      break;
  }
  return layOutAuto(directions, options.resolution);
}

}  // namespace scanmill
