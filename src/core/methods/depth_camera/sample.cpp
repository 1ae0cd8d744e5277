// Beams are processed in batches. All pixels of a batch are fetched together, because a source may read them back from
// a graphics card; all other work on a batch is done in blocks on all cores.

#include "methods/depth_camera/sample.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/parallel.h"
#include "methods/depth_camera/views.h"

namespace scanmill {

namespace {

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
