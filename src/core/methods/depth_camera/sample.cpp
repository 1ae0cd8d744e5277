// Beams are processed in batches. All pixels of a batch are fetched together, because a source may read them back from
// a graphics card; all other work on a batch is done in blocks on all cores.

#include "methods/depth_camera/sample.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <type_traits>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/depth_camera/views.h"

namespace scanmill {

namespace {

constexpr std::size_t kBatch = std::size_t{1} << 18;
constexpr std::size_t kSampleGrain = 16 * kBlock;
constexpr int kRounds = 3;
constexpr double kSameOrigin = 1e-6;    // m; a beam whose origin is this near to the camera is treated as starting in
                                        // the camera
constexpr double kFirstGuess = 20;      // m along a beam that does not start in the camera: first guess of its hit
constexpr double kFarAway = 1e6;        // m along the beam: second guess, if the first pixel shows no surface
constexpr double kLimitSlack = 1.2e-7;  // a range may be beyond a limit by this fraction: float32 rounding

// Beams that are sampled together, and the pixels that they fall into in this round.
struct Batch {
  std::size_t base = 0;  // index of the first of `count` consecutive beams; used only if `index` is empty
  std::size_t count = 0;
  std::vector<std::uint32_t> index;  // indices of the beams in RigBeams
  std::vector<double> u, v;          // px, position of each beam's pixel in its image
  std::vector<std::uint8_t> view;

  std::size_t beam(std::size_t i) const { return index.empty() ? base + i : index[i]; }
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
        choice_(choiceFor(source, hits.channels, options)),
        views_(viewsOf(source.cameras(), worldFromRig)),
        rigFromWorld_(transposed(toMatrix(worldFromRig.rotation))),
        rounds_(originsDiffer() ? kRounds : 1) {
    if (choice_.surfaceParameters) {
      hits.roughness.resize(hits.size());
      hits.metallic.resize(hits.size());
      hits.retroreflectance.resize(hits.size());
    }
  }

  std::uint64_t run() {
    for (std::size_t base = 0; base < beams_.direction.size(); base += kBatch) {
      Batch batch;
      batch.base = base;
      batch.resize(std::min(kBatch, beams_.direction.size() - base));
      findFirstPixels(batch);
      for (int round = 1; batch.count > 0; ++round) {
        fetch(batch);
        resolve(batch, round);
        if (round == rounds_) break;
        batch = nextRound(batch);
      }
    }
    return unseen_;
  }

 private:
  static PassChoice choiceFor(const PixelSource& source, Channels channels, const SampleOptions& options) {
    PassChoice choice = passesFor(channels, options);
    choice.surfaceParameters = !source.cameras().empty() && source.available().surfaceParameters;
    return choice;
  }

  // Returns true if a camera or a beam's origin is not at the origin of the rig.
  bool originsDiffer() const {
    const bool apart = std::any_of(views_.begin(), views_.end(),
                                   [](const CameraView& view) { return length(view.position) > kSameOrigin; });
    return apart || std::any_of(beams_.origin.begin(), beams_.origin.end(),
                                [](const Vec3d& o) { return dot(o, o) > kSameOrigin * kSameOrigin; });
  }

  void load(const Batch& batch, std::size_t first, std::size_t count, BeamBlock& block) const {
    block.count = count;
    const auto loadAll = [&](auto beam) {
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3d& d = beams_.direction[beam(i)];
        block.dx[i] = d.x;
        block.dy[i] = d.y;
        block.dz[i] = d.z;
      }
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3d o = beams_.origin.empty() ? Vec3d{} : beams_.origin[beam(i)];
        block.ox[i] = o.x;
        block.oy[i] = o.y;
        block.oz[i] = o.z;
      }
    };
    if (batch.index.empty()) {
      loadAll([at = batch.base + first](std::size_t i) { return at + i; });
    } else {
      loadAll([at = &batch.index[first]](std::size_t i) { return at[i]; });
    }
  }

  // Finds the pixels of the first round: the pixel in the direction of the beam or, if originsDiffer(), the pixel of a
  // point on the beam.
  void findFirstPixels(Batch& batch) {
    parallelFor(batch.count, kSampleGrain, [&](std::size_t begin, std::size_t end) {
      BeamBlock block;
      std::uint64_t unseen = 0;
      for (std::size_t first = begin; first < end; first += kBlock) {
        const std::size_t count = std::min(kBlock, end - first);
        load(batch, first, count, block);
        project(views_, block.dx, block.dy, block.dz, count, ProjectedAs::Directions, batch.at(first));
        if (rounds_ > 1) usePixelsOfGuess(batch, first, block);
        for (std::size_t i = first; i < first + count; ++i) unseen += batch.view[i] == kNoView ? 1 : 0;
      }
      unseen_ += unseen;
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

  // Fetches the batch's pixels, and rounds their depths as a z-buffer would. Half500 is not applied here, because it
  // rounds points and not depths.
  void fetch(const Batch& batch) {
    addresses_.resize(batch.count);
    parallelFor(batch.count, kSampleGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        addresses_[i] = batch.view[i] == kNoView ? kNoPixel : views_[batch.view[i]].at(batch.u[i], batch.v[i]);
      }
    });
    source_.fetch(addresses_, choice_, planes_);
    if (options_.depth != DepthFormat::Unorm24 && options_.depth != DepthFormat::Unorm16) return;
    parallelFor(batch.count, kSampleGrain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        planes_.depth[i] = storedDepth(planes_.depth[i], options_.depth, options_.nearest, options_.farthest);
      }
    });
  }

  void resolve(Batch& batch, int round) {
    needsRound_.assign(batch.count, 0);
    parallelFor(batch.count, kSampleGrain, [&](std::size_t begin, std::size_t end) {
      BeamBlock block;
      ImageHits found;
      for (std::size_t first = begin; first < end; first += kBlock) {
        const std::size_t count = std::min(kBlock, end - first);
        load(batch, first, count, block);
        for (std::size_t i = 0; i < count;) {  // one turn for each run of successive beams in the same image
          const std::uint8_t view = batch.view[first + i];
          std::size_t next = i + 1;
          while (next < count && batch.view[first + next] == view) ++next;
          if (view == kNoView) {
            std::fill(found.range + i, found.range + next, INFINITY);
            std::fill(found.along + i, found.along + next, 0.0);
          } else {
            const BlockPixels pixels{&batch.u[first], &batch.v[first], &planes_, first};
            measure(options_, views_[view], rigFromWorld_, pixels, i, next, block, found);
          }
          i = next;
        }
        std::fill_n(found.needsRound, count, false);
        if (round < rounds_) findNextPixels(batch, first, round == 1, block, found);
        store(batch, first, count, found);
      }
    });
  }

  // Sets the pixel of the next round to the pixel of the hit point, if that differs from the pixel of this round. If
  // the first round shows no surface, the next pixel is the pixel of a point far away on the beam.
  void findNextPixels(Batch& batch, std::size_t first, bool isFirst, const BeamBlock& block, ImageHits& found) {
    alignas(64) double x[kBlock], y[kBlock], z[kBlock], u[kBlock], v[kBlock];
    std::uint8_t view[kBlock];
    for (std::size_t i = 0; i < block.count; ++i) {
      const double range = found.range[i] < kFarAway ? found.range[i] : kFarAway;
      x[i] = block.ox[i] + block.dx[i] * range;
      y[i] = block.oy[i] + block.dy[i] * range;
      z[i] = block.oz[i] + block.dz[i] * range;
    }
    project(views_, x, y, z, block.count, ProjectedAs::Points, {u, v, view});
    for (std::size_t i = 0; i < block.count; ++i) {
      const std::size_t at = first + i;
      const bool otherPixel = view[i] != batch.view[at] || std::floor(u[i]) != std::floor(batch.u[at]) ||
                              std::floor(v[i]) != std::floor(batch.v[at]);
      if (!otherPixel || view[i] == kNoView || !(isFirst || found.range[i] < INFINITY)) continue;
      found.needsRound[i] = true;
      batch.u[at] = u[i];
      batch.v[at] = v[i];
      batch.view[at] = view[i];
      needsRound_[at] = 1;
    }
  }

  // Returns the beams of the batch whose pixels need another round of the search.
  Batch nextRound(const Batch& batch) {
    Batch next;
    const auto count = static_cast<std::size_t>(std::count(needsRound_.begin(), needsRound_.begin() + batch.count, 1));
    next.resize(count);
    next.index.resize(count);
    for (std::size_t i = 0, to = 0; i < batch.count; ++i) {
      if (needsRound_[i] == 0) continue;
      next.index[to] = static_cast<std::uint32_t>(batch.beam(i));
      next.u[to] = batch.u[i];
      next.v[to] = batch.v[i];
      next.view[to] = batch.view[i];
      ++to;
    }
    return next;
  }

  void store(const Batch& batch, std::size_t first, std::size_t count, const ImageHits& found) const {
    const double nearest = beams_.minRange > 0 ? beams_.minRange * (1 - kLimitSlack) : 1e-30;
    const double farthest = beams_.maxRange * (1 + kLimitSlack);
    bool hit[kBlock];
    std::uint32_t to[kBlock];
    std::size_t from[kBlock];
    std::size_t done = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (found.needsRound[i]) continue;
      from[done] = i;
      to[done] = beams_.beam[batch.beam(first + i)];
      hit[done] = found.range[i] >= nearest && found.range[i] <= farthest;
      hits_.range[to[done]] = hit[done] ? static_cast<float>(found.range[i]) : kMiss;
      ++done;
    }
    const auto put = [&](auto& column, const auto& plane) {
      if (column.empty() || plane.empty()) return;
      for (std::size_t k = 0; k < done; ++k) {
        column[to[k]] = hit[k] ? plane[first + from[k]] : typename std::decay_t<decltype(plane)>::value_type{};
      }
    };
    forEachPass([&](const ChannelRow& row, auto plane, auto column) {
      if (row.channel != Channel::Range && row.channel != Channel::Normal) put(hits_.*column, planes_.*plane);
    });
    put(hits_.roughness, planes_.roughness);
    put(hits_.metallic, planes_.metallic);
    put(hits_.retroreflectance, planes_.retroreflectance);
    if (hits_.channels.has(Channel::Normal)) {
      for (std::size_t k = 0; k < done; ++k) {
        const Vec3f& n = planes_.normal[first + from[k]];
        hits_.normal[to[k]] = !hit[k] ? Vec3f{} : found.along[from[k]] > 0 ? -n : n;
      }
    }
    static_assert(kChannels.size() == 8, "fill the new channel here if no plane of the images has it");
    if (hits_.channels.has(Channel::Incidence)) {
      for (std::size_t k = 0; k < done; ++k) {
        hits_.incidence[to[k]] = hit[k] ? static_cast<float>(std::min(std::abs(found.along[from[k]]), 1.0)) : 0.0f;
      }
    }
  }

  PixelSource& source_;
  const RigBeams& beams_;
  const SampleOptions& options_;
  Hits& hits_;
  PassChoice choice_;
  std::vector<CameraView> views_;
  Mat3 rigFromWorld_;
  std::vector<PixelAddress> addresses_;  // of the batch's pixels
  PassPlanes planes_;                    // values of the batch's pixels
  int rounds_;
  std::vector<std::uint8_t> needsRound_;
  std::atomic<std::uint64_t> unseen_{0};
};

}  // namespace

std::uint64_t samplePixels(PixelSource& source, const Pose& worldFromRig, const RigBeams& beams,
                           const SampleOptions& options, Hits& hits) {
  return Sampler(source, worldFromRig, beams, options, hits).run();
}

PassChoice passesFor(Channels channels, const SampleOptions& options) {
  PassChoice choice;
  choice.channels = (channels & channelsThat(&ChannelRow::rendered)) | Channel::Range;
  if (channels.has(Channel::Incidence) || options.sampling == Sampling::Plane) choice.channels |= Channel::Normal;
  return choice;
}

}  // namespace scanmill
