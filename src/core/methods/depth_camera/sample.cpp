// Beams are processed in batches. All pixels of a batch are fetched together, because a source may read them back from
// a graphics card; all other work on a batch is done in blocks on all cores.

#include "methods/depth_camera/sample.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "base/error.h"
#include "base/parallel.h"

namespace scanmill {

namespace {

// An image and its camera, in rig axes.
struct CameraView {
  Vec3d right, down, forward;  // unit vectors of the camera's axes
  Vec3d position;              // m, position of the camera
  double fx, fy, cx, cy;       // px, focal lengths and principal point
  double width, height;        // px
  double lastU, lastV;         // px, the largest doubles below `width` and `height`
  std::uint32_t rowLength;     // number of pixels in a row
  PixelAddress firstPixel;     // address of the image's first pixel

  // Returns the address of the pixel at (u, v) (px), which must be inside of the image.
  PixelAddress addressAt(double u, double v) const {
    return firstPixel + static_cast<PixelAddress>(static_cast<std::int32_t>(v)) * rowLength +
           static_cast<PixelAddress>(static_cast<std::int32_t>(u));
  }
};

constexpr std::uint8_t kNoView = 0xFF;
constexpr std::size_t kBlock = 256;  // beams that are processed together: their arrays stay in the L1 cache

// Beams as a structure of arrays, in rig axes.
struct BeamBlock {
  std::size_t count = 0;
  alignas(64) double ox[kBlock], oy[kBlock], oz[kBlock];  // origins (m)
  alignas(64) double dx[kBlock], dy[kBlock], dz[kBlock];
};

// Arrays for the projections of points: u and v (px) in the image with the index `view`.
struct ImagePositions {
  double* u;
  double* v;
  std::uint8_t* view;  // kNoView: no image contains the point; u and v are then 0
};

enum class ProjectedAs { Points, Directions };

// Hits of a block of beams.
struct ImageHits {
  alignas(64) double a[kBlock], b[kBlock],
      depth[kBlock];  // pixel's point: x / depth, y / depth (camera axes); depth (m)
  alignas(64) double px[kBlock], py[kBlock], pz[kBlock];  // m, hit point in rig axes
  alignas(64) double nx[kBlock], ny[kBlock], nz[kBlock];  // normal in rig axes
  alignas(64) double range[kBlock];                       // m, range of the hit; NaN or infinite if nothing is hit
  alignas(64) double cosine[kBlock];                      // dot product of normal and beam direction
  bool needsRound[kBlock];                                // true if the next round must sample another pixel
};

// Pixels of the beams of a block: their positions in the image, and their values.
struct BlockPixels {
  const double* u;  // px, column in the image, by beam of the block
  const double* v;
  const PassPlanes* planes;  // values of the batch's pixels
  std::size_t first;         // index in `planes` of the block's first pixel
};

constexpr double kEdge = 1e-6;       // px; margin, so that a beam along the border of two images is in one of them
constexpr double kInFront = 1e-9;    // smallest depth in front of a camera: m for points, without unit for directions
constexpr double kNoViewYet = 1000;  // stands for kNoView while views' indices are doubles, so that g++ can vectorise

// The range to a tangent plane is used if it is from 1 / kPlaneErrorBound to kPlaneErrorBound times the distance of the
// pixel's point. Otherwise the plane is seen edge-on, and the range is unreliable.
constexpr double kPlaneErrorBound = 2;

constexpr std::size_t kBatch = std::size_t{1} << 18;  // beams whose pixels are fetched together
constexpr std::size_t kSampleGrain = 16 * kBlock;     // beams per task
constexpr int kRounds = 3;              // most pixels that are fetched for a beam that does not start in the camera
constexpr double kSameOrigin = 1e-6;    // m; a beam whose origin is this near to the camera is treated as starting in
                                        // the camera
constexpr double kFirstGuess = 20;      // m along a beam that does not start in the camera: first guess of its hit
constexpr double kFarAway = 1e6;        // m along the beam: second guess, if the first pixel shows no surface
constexpr double kLeastRange = 1e-30;   // m; excludes a range of 0 if the sensor has no minimum range
constexpr double kLimitSlack = 1.2e-7;  // a range may be beyond a limit by this fraction, because of float32 rounding

// Returns the nearest half-precision number, ties to even. Finite values beyond kLargest are clamped to kLargest.
double asHalf(double value) {
  constexpr double kLargest = 65504;
  constexpr int kBits = 11;            // bits of the significand
  constexpr int kSmallestPower = -24;  // exponent of the spacing of subnormal numbers
  if (!std::isfinite(value)) return value;
  int power = 0;
  std::frexp(value, &power);
  const double step = std::ldexp(1.0, std::max(power - kBits, kSmallestPower));
  return std::clamp(std::nearbyint(value / step) * step, -kLargest, kLargest);
}

// Returns a depth (m) as a fixed-point z-buffer of `bits` bits stores it. `nearest`, `farthest`: near, far plane (m).
double asUnorm(double depth, int bits, double nearest, double farthest) {
  const double steps = std::ldexp(1.0, bits) - 1;
  const double clamped = std::clamp(depth, nearest, farthest);
  const double fraction = (1 / nearest - 1 / clamped) / (1 / nearest - 1 / farthest);  // 0 to 1
  const double rounded = std::nearbyint(fraction * steps) / steps;
  return 1 / (1 / nearest - rounded * (1 / nearest - 1 / farthest));
}

// Rounds the points that the pixels show (camera axes) to DepthFormat::Half500.
void roundToHalf(std::size_t begin, std::size_t end, ImageHits& hits) {
  const auto rounded = [](double coordinate) {
    return double{storedDepth(static_cast<float>(coordinate), DepthFormat::Half500, 0, 0)};
  };
  for (std::size_t i = begin; i < end; ++i) {
    const double z = rounded(hits.depth[i]);
    hits.a[i] = rounded(hits.a[i] * hits.depth[i]) / z;
    hits.b[i] = rounded(hits.b[i] * hits.depth[i]) / z;
    hits.depth[i] = z;
  }
}

// Computes the points that the pixels show, in rig axes.
void findHitPoints(const CameraView& view, std::size_t begin, std::size_t end, ImageHits& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    const double a = hits.a[i];
    const double b = hits.b[i];
    const double z = hits.depth[i];
    hits.px[i] = (view.right.x * a + view.down.x * b + view.forward.x) * z + view.position.x;
    hits.py[i] = (view.right.y * a + view.down.y * b + view.forward.y) * z + view.position.y;
    hits.pz[i] = (view.right.z * a + view.down.z * b + view.forward.z) * z + view.position.z;
  }
}

// Sets each range to the distance from the beam's origin to the point that the pixel shows.
void usePointRanges(std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    const double x = hits.px[i] - block.ox[i];
    const double y = hits.py[i] - block.oy[i];
    const double z = hits.pz[i] - block.oz[i];
    hits.range[i] = std::sqrt(x * x + y * y + z * z);
    hits.cosine[i] = 0;
  }
}

// Rotates the pixels' normals (world axes) into rig axes.
void rotateNormals(const Vec3f* normal, const Mat3& rigFromWorld, std::size_t begin, std::size_t end,
                   const BeamBlock& block, ImageHits& hits) {
  const Mat3& m = rigFromWorld;
  for (std::size_t i = begin; i < end; ++i) {
    const auto x = double{normal[i].x};
    const auto y = double{normal[i].y};
    const auto z = double{normal[i].z};
    hits.nx[i] = m.x.x * x + m.y.x * y + m.z.x * z;
    hits.ny[i] = m.x.y * x + m.y.y * y + m.z.y * z;
    hits.nz[i] = m.x.z * x + m.y.z * y + m.z.z * z;
    hits.cosine[i] = hits.nx[i] * block.dx[i] + hits.ny[i] * block.dy[i] + hits.nz[i] * block.dz[i];
  }
}

// Replaces each range by the range to the tangent plane at the pixel's point if kPlaneErrorBound allows that range.
void usePlaneRanges(std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits) {
  for (std::size_t i = begin; i < end; ++i) {
    const double height = hits.nx[i] * (hits.px[i] - block.ox[i]) + hits.ny[i] * (hits.py[i] - block.oy[i]) +
                          hits.nz[i] * (hits.pz[i] - block.oz[i]);
    const double range = height / hits.cosine[i];
    const double pointRange = hits.range[i];
    // Also false if the beam does not hit the plane in front of the sensor: `range` is then NaN, infinite or negative.
    const bool isReliable = (range <= pointRange * kPlaneErrorBound) & (range * kPlaneErrorBound >= pointRange);
    hits.range[i] = isReliable ? range : pointRange;
  }
}

// Returns the views of these cameras, in rig axes. Throws InputError if the cameras are too many.
std::vector<CameraView> viewsOf(const std::vector<Camera>& cameras, const Pose& worldFromRig) {
  std::vector<CameraView> views;
  const Mat3 rigFromWorld = transposed(toMatrix(worldFromRig.rotation));
  PixelAddress firstPixel = 0;
  for (const Camera& camera : cameras) {
    const Mat3 axes = rigFromWorld * toMatrix(camera.worldFromCamera.rotation);
    // Subtract before rotating: far from the world's origin this keeps a precision of micrometres.
    const Vec3d position = rigFromWorld * (camera.worldFromCamera.translation - worldFromRig.translation);
    views.push_back({.right = axes.x,
                     .down = axes.y,
                     .forward = axes.z,
                     .position = position,
                     .fx = camera.fx,
                     .fy = camera.fy,
                     .cx = camera.cx,
                     .cy = camera.cy,
                     .width = static_cast<double>(camera.width),
                     .height = static_cast<double>(camera.height),
                     .lastU = std::nextafter(static_cast<double>(camera.width), 0.0),
                     .lastV = std::nextafter(static_cast<double>(camera.height), 0.0),
                     .rowLength = camera.width,
                     .firstPixel = firstPixel});
    firstPixel += static_cast<PixelAddress>(camera.pixels());
  }
  if (views.size() >= kNoView)
    throw InputError("a shot has " + std::to_string(views.size()) + " images, which are too many");
  return views;
}

// Projects `count` points (m, rig axes) or directions, at most kBlock, into the images. If several images contain a
// point, the image in which the point has the largest depth is used.
void project(std::span<const CameraView> views, const double* x, const double* y, const double* z, std::size_t count,
             ProjectedAs kind, ImagePositions positions) {
  // The position (px) and the depth (m) of each point in the best image so far, and the image's index, as a double.
  alignas(64) double bestU[kBlock], bestV[kBlock], bestDepth[kBlock], bestView[kBlock];
  for (std::size_t i = 0; i < count; ++i) {
    bestU[i] = bestV[i] = bestDepth[i] = 0;
    bestView[i] = kNoViewYet;
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    // Local copies, because g++ does not vectorise the loop over points with references.
    const CameraView view = views[k];
    const auto index = static_cast<double>(k);
    const Vec3d origin = kind == ProjectedAs::Points ? view.position : Vec3d{};
    const Vec3d right = view.right * view.fx;
    const Vec3d down = view.down * view.fy;
    const Vec3d forward = view.forward;
    const double widest = view.width + kEdge;
    const double highest = view.height + kEdge;
    for (std::size_t i = 0; i < count; ++i) {
      const double px = x[i] - origin.x;
      const double py = y[i] - origin.y;
      const double pz = z[i] - origin.z;
      const double depth = forward.x * px + forward.y * py + forward.z * pz;
      const double scale = 1 / depth;
      double u = (right.x * px + right.y * py + right.z * pz) * scale + view.cx;
      double v = (down.x * px + down.y * py + down.z * pz) * scale + view.cy;
      const bool isBetter =
          (depth > kInFront) & (depth > bestDepth[i]) & (u >= -kEdge) & (u <= widest) & (v >= -kEdge) & (v <= highest);
      u = u > 0 ? u : 0;
      u = u < view.lastU ? u : view.lastU;
      v = v > 0 ? v : 0;
      v = v < view.lastV ? v : view.lastV;
      bestU[i] = isBetter ? u : bestU[i];
      bestV[i] = isBetter ? v : bestV[i];
      bestDepth[i] = isBetter ? depth : bestDepth[i];
      bestView[i] = isBetter ? index : bestView[i];
    }
  }
  std::copy_n(bestU, count, positions.u);
  std::copy_n(bestV, count, positions.v);
  for (std::size_t i = 0; i < count; ++i) {
    const int view = static_cast<int>(bestView[i]);
    positions.view[i] = static_cast<std::uint8_t>(view < int{kNoView} ? view : int{kNoView});
  }
}

// Fills `hits`, except `needsRound`, for the beams [begin, end) of a block, which all fall into the image of `view`.
void measure(const SampleOptions& options, const CameraView& view, const Mat3& rigFromWorld, const BlockPixels& pixels,
             std::size_t begin, std::size_t end, const BeamBlock& block, ImageHits& hits) {
  const double* u = pixels.u;
  const double* v = pixels.v;
  const float* depth = &pixels.planes->depth[pixels.first];
  const double perFx = 1 / view.fx;
  const double perFy = 1 / view.fy;
  for (std::size_t i = begin; i < end; ++i) {
    hits.a[i] = (std::floor(u[i]) + 0.5 - view.cx) * perFx;
    hits.b[i] = (std::floor(v[i]) + 0.5 - view.cy) * perFy;
    hits.depth[i] = double{depth[i]};
  }
  if (options.depth == DepthFormat::Half500) roundToHalf(begin, end, hits);
  findHitPoints(view, begin, end, hits);
  usePointRanges(begin, end, block, hits);
  if (pixels.planes->normal.empty()) return;
  rotateNormals(&pixels.planes->normal[pixels.first], rigFromWorld, begin, end, block, hits);
  if (options.sampling == Sampling::Plane) usePlaneRanges(begin, end, block, hits);
}

// Beams that are sampled together, and the pixels that they fall into in this round.
struct Batch {
  std::size_t firstBeam = 0;  // index of the first of `count` consecutive beams; used only if `beams` is empty
  std::size_t count = 0;
  std::vector<std::uint32_t> beams;  // indices of the beams in RigBeams
  std::vector<double> u, v;          // px, position of each beam's pixel in its image
  std::vector<std::uint8_t> view;    // index of the image; kNoView: none

  std::size_t beam(std::size_t i) const { return beams.empty() ? firstBeam + i : beams[i]; }
  void resize(std::size_t n) {
    count = n;
    u.resize(n);
    v.resize(n);
    view.resize(n);
  }
  ImagePositions at(std::size_t i) { return {&u[i], &v[i], &view[i]}; }
};

class Sampler {
 public:
  Sampler(PixelSource& source, const Pose& worldFromRig, const RigBeams& beams, const SampleOptions& options,
          Hits& hits)
      : source_(source),
        beams_(beams),
        options_(options),
        hits_(hits),
        choice_(passesFor(hits.channels, options)),
        views_(viewsOf(source.cameras(), worldFromRig)),
        rigFromWorld_(transposed(toMatrix(worldFromRig.rotation))),
        rounds_(originsDiffer() ? kRounds : 1) {
    choice_.surfaceParameters = !source.cameras().empty() && source.available().surfaceParameters;
    if (choice_.surfaceParameters) {
      for (auto* column : {&hits.roughness, &hits.metallic, &hits.retroreflectance}) column->resize(hits.size());
    }
  }

  // Samples all beams. Returns the number of beams that are in no image. Must be called only once.
  std::uint64_t run() {
    for (std::size_t firstBeam = 0; firstBeam < beams_.direction.size(); firstBeam += kBatch) {
      Batch batch;
      batch.firstBeam = firstBeam;
      batch.resize(std::min(kBatch, beams_.direction.size() - firstBeam));
      findFirstPixels(batch);
      for (int round = 1; batch.count > 0; ++round) {
        fetch(batch);
        resolve(batch, round);
        if (round == rounds_) break;
        batch = nextRound(batch);
      }
    }
    return beamsInNoImage_;
  }

 private:
  // Returns true if a camera or a beam's origin is not at the origin of the rig.
  bool originsDiffer() const {
    const auto isApart = [](const Vec3d& position) { return dot(position, position) > kSameOrigin * kSameOrigin; };
    return std::ranges::any_of(views_, isApart, &CameraView::position) || std::ranges::any_of(beams_.origin, isApart);
  }

  // Loads the batch's beams [first, first + count) into a block.
  void load(const Batch& batch, std::size_t first, std::size_t count, BeamBlock& block) const {
    block.count = count;
    const auto loadAll = [&](auto beamOf) {  // beamOf(i): index of the block's beam i
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3d& d = beams_.direction[beamOf(i)];
        block.dx[i] = d.x;
        block.dy[i] = d.y;
        block.dz[i] = d.z;
      }
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3d o = beams_.origin.empty() ? Vec3d{} : beams_.origin[beamOf(i)];
        block.ox[i] = o.x;
        block.oy[i] = o.y;
        block.oz[i] = o.z;
      }
    };
    if (batch.beams.empty()) {
      loadAll([firstBeam = batch.firstBeam + first](std::size_t i) { return firstBeam + i; });
    } else {
      loadAll([beams = &batch.beams[first]](std::size_t i) { return beams[i]; });
    }
  }

  // Finds each beam's first pixel: in the beam's direction or, if originsDiffer(), at a point on the beam.
  void findFirstPixels(Batch& batch) {
    parallelFor(batch.count, kSampleGrain, [&](std::size_t begin, std::size_t end) {
      BeamBlock block;
      std::uint64_t beamsInNoImage = 0;
      for (std::size_t first = begin; first < end; first += kBlock) {
        const std::size_t count = std::min(kBlock, end - first);
        load(batch, first, count, block);
        project(views_, block.dx, block.dy, block.dz, count, ProjectedAs::Directions, batch.at(first));
        if (rounds_ > 1) usePixelsOfGuess(batch, first, block);
        for (std::size_t i = first; i < first + count; ++i) beamsInNoImage += batch.view[i] == kNoView ? 1 : 0;
      }
      beamsInNoImage_ += beamsInNoImage;
    });
  }

  // Replaces the pixel of each beam by the pixel of the beam's point at kFirstGuess, if that point is in an image.
  void usePixelsOfGuess(Batch& batch, std::size_t first, const BeamBlock& block) const {
    alignas(64) double x[kBlock], y[kBlock], z[kBlock], u[kBlock], v[kBlock];
    std::uint8_t view[kBlock];
    for (std::size_t i = 0; i < block.count; ++i) {
      x[i] = block.ox[i] + block.dx[i] * kFirstGuess;
      y[i] = block.oy[i] + block.dy[i] * kFirstGuess;
      z[i] = block.oz[i] + block.dz[i] * kFirstGuess;
    }
    project(views_, x, y, z, block.count, ProjectedAs::Points, {u, v, view});
    for (std::size_t i = 0; i < block.count; ++i) {
      if (view[i] == kNoView) continue;
      batch.u[first + i] = u[i];
      batch.v[first + i] = v[i];
      batch.view[first + i] = view[i];
    }
  }

  // Fetches the batch's pixels, and rounds depths as a z-buffer would. Half500 rounds points and is applied later.
  void fetch(const Batch& batch) {
    addresses_.resize(batch.count);
    parallelForEach(batch.count, kSampleGrain, [&](std::size_t i) {
      addresses_[i] = batch.view[i] == kNoView ? kNoPixel : views_[batch.view[i]].addressAt(batch.u[i], batch.v[i]);
    });
    source_.fetch(addresses_, choice_, planes_);
    if (options_.depth != DepthFormat::Unorm24 && options_.depth != DepthFormat::Unorm16) return;
    parallelForEach(batch.count, kSampleGrain, [&](std::size_t i) {
      planes_.depth[i] = storedDepth(planes_.depth[i], options_.depth, options_.nearest, options_.farthest);
    });
  }

  // Computes hits from the fetched pixels, and stores hits that need no further round. `round`: counted from 1.
  void resolve(Batch& batch, int round) {
    needsRound_.assign(batch.count, 0);
    parallelFor(batch.count, kSampleGrain, [&](std::size_t begin, std::size_t end) {
      BeamBlock block;
      ImageHits hits;
      for (std::size_t first = begin; first < end; first += kBlock) {
        load(batch, first, std::min(kBlock, end - first), block);
        measureBlock(batch, first, block, hits);
        std::fill_n(hits.needsRound, block.count, false);
        if (round < rounds_) findNextPixels(batch, first, round == 1, block, hits);
        store(batch, first, block.count, hits);
      }
    });
  }

  // Fills `hits`, except `needsRound`, for the beams of `block`: the batch's beams from the index `first` on.
  void measureBlock(const Batch& batch, std::size_t first, const BeamBlock& block, ImageHits& hits) const {
    const BlockPixels pixels{&batch.u[first], &batch.v[first], &planes_, first};
    std::size_t end = 0;
    for (std::size_t begin = 0; begin < block.count; begin = end) {  // for each run of beams in the same image
      const std::uint8_t view = batch.view[first + begin];
      for (end = begin + 1; end < block.count && batch.view[first + end] == view; ++end) continue;
      if (view == kNoView) {
        std::fill(hits.range + begin, hits.range + end, INFINITY);
        std::fill(hits.cosine + begin, hits.cosine + end, 0.0);
      } else {
        measure(options_, views_[view], rigFromWorld_, pixels, begin, end, block, hits);
      }
    }
  }

  // If a beam's hit point is in another pixel than the pixel of this round, sets the beam's pixel for the next round to
  // that pixel. If the first round shows no surface, takes a point far away on the beam instead of the hit point.
  void findNextPixels(Batch& batch, std::size_t first, bool isFirstRound, const BeamBlock& block, ImageHits& hits) {
    alignas(64) double x[kBlock], y[kBlock], z[kBlock], u[kBlock], v[kBlock];
    std::uint8_t view[kBlock];
    for (std::size_t i = 0; i < block.count; ++i) {
      const double range = hits.range[i] < kFarAway ? hits.range[i] : kFarAway;
      x[i] = block.ox[i] + block.dx[i] * range;
      y[i] = block.oy[i] + block.dy[i] * range;
      z[i] = block.oz[i] + block.dz[i] * range;
    }
    project(views_, x, y, z, block.count, ProjectedAs::Points, {u, v, view});
    for (std::size_t i = 0; i < block.count; ++i) {
      const std::size_t beam = first + i;  // index in the batch
      const bool isSamePixel = view[i] == batch.view[beam] && std::floor(u[i]) == std::floor(batch.u[beam]) &&
                               std::floor(v[i]) == std::floor(batch.v[beam]);
      if (isSamePixel || view[i] == kNoView || !(isFirstRound || hits.range[i] < INFINITY)) continue;
      hits.needsRound[i] = true;
      batch.u[beam] = u[i];
      batch.v[beam] = v[i];
      batch.view[beam] = view[i];
      needsRound_[beam] = 1;
    }
  }

  // Returns the beams of the batch whose pixels need another round of the search.
  Batch nextRound(const Batch& batch) {
    Batch next;
    for (std::size_t i = 0; i < batch.count; ++i) {
      if (needsRound_[i] == 0) continue;
      next.beams.push_back(static_cast<std::uint32_t>(batch.beam(i)));
      next.u.push_back(batch.u[i]);
      next.v.push_back(batch.v[i]);
      next.view.push_back(batch.view[i]);
    }
    next.count = next.beams.size();
    return next;
  }

  // Stores the hits of the batch's beams [first, first + count) that need no further round.
  void store(const Batch& batch, std::size_t first, std::size_t count, const ImageHits& hits) const {
    const double nearest = beams_.minRange > 0 ? beams_.minRange * (1 - kLimitSlack) : kLeastRange;
    const double farthest = beams_.maxRange * (1 + kLimitSlack);
    // The stored beams: index in the block, index in hits_, and whether they hit.
    std::size_t inBlock[kBlock];
    std::uint32_t inHits[kBlock];
    bool isHit[kBlock];
    std::size_t stored = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (hits.needsRound[i]) continue;
      inBlock[stored] = i;
      inHits[stored] = beams_.beam[batch.beam(first + i)];
      isHit[stored] = hits.range[i] >= nearest && hits.range[i] <= farthest;
      ++stored;
    }
    // Sets a column of hits_ to valueOf(index in the block), and to zero for misses.
    const auto fill = [&]<class T>(std::vector<T>& column, const auto& valueOf) {
      for (std::size_t k = 0; k < stored; ++k) column[inHits[k]] = isHit[k] ? valueOf(inBlock[k]) : T{};
    };
    const auto copyPlane = [&]<class T>(std::vector<T>& column, const std::vector<T>& plane) {
      if (!column.empty() && !plane.empty()) fill(column, [&](std::size_t i) { return plane[first + i]; });
    };
    for (std::size_t k = 0; k < stored; ++k) {
      hits_.range[inHits[k]] = isHit[k] ? static_cast<float>(hits.range[inBlock[k]]) : kMiss;
    }
    forEachPass([&](const ChannelRow& row, auto plane, auto column) {
      if (row.channel != Channel::Range && row.channel != Channel::Normal) copyPlane(hits_.*column, planes_.*plane);
    });
    copyPlane(hits_.roughness, planes_.roughness);
    copyPlane(hits_.metallic, planes_.metallic);
    copyPlane(hits_.retroreflectance, planes_.retroreflectance);
    if (hits_.channels.has(Channel::Normal)) {
      fill(hits_.normal, [&](std::size_t i) {
        const Vec3f& normal = planes_.normal[first + i];
        return hits.cosine[i] > 0 ? -normal : normal;
      });
    }
    static_assert(kChannels.size() == 8, "fill the new channel here if no plane of the images has it");
    if (hits_.channels.has(Channel::Incidence)) {
      fill(hits_.incidence, [&](std::size_t i) { return static_cast<float>(std::min(std::abs(hits.cosine[i]), 1.0)); });
    }
  }

  PixelSource& source_;
  const RigBeams& beams_;
  const SampleOptions& options_;
  Hits& hits_;
  PassChoice choice_;
  std::vector<CameraView> views_;
  Mat3 rigFromWorld_;
  std::vector<PixelAddress> addresses_;           // addresses of the batch's pixels
  PassPlanes planes_;                             // values of the batch's pixels
  int rounds_;                                    // 1 if all beams start in all cameras
  std::vector<std::uint8_t> needsRound_;          // by beam of the batch: 1 if its next pixel differs
  std::atomic<std::uint64_t> beamsInNoImage_{0};  // number of beams that are in no image
};

}  // namespace

std::uint64_t samplePixels(PixelSource& source, const Pose& worldFromRig, const RigBeams& beams,
                           const SampleOptions& options, Hits& hits) {
  return Sampler(source, worldFromRig, beams, options, hits).run();
}

float storedDepth(float depth, DepthFormat format, double nearest, double farthest) {
  constexpr double kShift = 500;  // m, added to coordinates by DepthFormat::Half500
  if (!(depth < kNoDepth)) return depth;
  switch (format) {
    case DepthFormat::Float32:
      break;
    case DepthFormat::Unorm24:
      return static_cast<float>(asUnorm(double{depth}, 24, nearest, farthest));
    case DepthFormat::Unorm16:
      return static_cast<float>(asUnorm(double{depth}, 16, nearest, farthest));
    case DepthFormat::Half500:
      return static_cast<float>(asHalf(double{depth} + kShift) - kShift);
  }
  return depth;
}

PassChoice passesFor(Channels channels, const SampleOptions& options) {
  PassChoice choice;
  choice.channels = (channels & channelsThat(&ChannelRow::rendered)) | Channel::Range;
  if (channels.has(Channel::Incidence) || options.sampling == Sampling::Plane) choice.channels |= Channel::Normal;
  return choice;
}

}  // namespace scanmill
