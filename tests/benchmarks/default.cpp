// Prints what a scan of a town of the quickstart costs beside what Embree alone takes for its rays, on one thread, as
// processor time.
//   bench_default [FRAMES]     frames of the town, 12 unless given

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stage_clock.h"
#include "methods/ray_tracing/packet.h"
#include "methods/world/resolve.h"
#include "methods/world/worlds.h"
#include "pipeline/run/generate.h"
#include "pipeline/run/run_shot.h"
#include "scene/embree.h"
#include "sense/sense.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// Passes shots on to a method, and keeps them: all rays of a scan, those that go on behind glass and off mirrors too.
class Recording : public Method {
 public:
  explicit Recording(const Method& method) : method_(method) {}
  TraceAccount prepare(const Shot& shot) const override { return method_.prepare(shot); }
  TraceAccount trace(const Shot& shot, Channels channels, Hits& hits) const override {
    shots_.push_back(shot);
    return method_.trace(shot, channels, hits);
  }
  std::vector<ModelledItem> modelled() const override { return method_.modelled(); }
  std::uint64_t memoryBytes() const override { return method_.memoryBytes(); }
  std::vector<Shot> take() const { return std::exchange(shots_, {}); }

 private:
  const Method& method_;
  mutable std::vector<Shot> shots_;
};

// The hierarchies of a scene without filters, and the time that Embree takes for rays in them.
class Bare {
 public:
  explicit Bare(const Scene& scene) : worlds_(scene, Instancing::Auto, {}) {}

  double secondsOf(const Shot& shot) {
    const BeamTable& beams = *shot.beams;
    const std::shared_ptr<const World> world =
        worlds_.near(shot.worldFromSensor.front().translation, farthestEnd(shot), shot.time, shot.duration);
    const ShotFrame frame = frameOf(shot, world->origin);
    packets_.clear();
    for (std::uint32_t ring = 0; ring < beams.rings; ++ring) {
      for (std::uint32_t column = 0; column < beams.columns; column += kPacket) {
        add(shot, frame, {ring, column, 1, std::min<std::uint32_t>(kPacket, beams.columns - column)},
            world->revolution.duration);
      }
    }
    // Once and with the caches as the frame before has left them, as in a run.
    const double begin = threadSeconds();
    EmbreeContext context = newEmbreeContext();
    for (const Packet& packet : packets_) {
      RTCRayHit16 traced = packet.rays;
      intersectPacket(world->embree.get(), context, packet.valid, traced);
    }
    return threadSeconds() - begin;
  }

 private:
  struct Packet {
    alignas(64) RTCRayHit16 rays;
    alignas(64) int valid[kPacket];
  };

  void add(const Shot& shot, const ShotFrame& frame, const Tile& tile, double duration) {
    const BeamTable& beams = *shot.beams;
    Rays rays;
    setUpRays(shot, frame, tile, rays);
    Packet packet{};
    for (int i = 0; i < kPacket; ++i) {
      RTCRay16& r = packet.rays.ray;
      r.org_x[i] = static_cast<float>(rays.ox[i]);
      r.org_y[i] = static_cast<float>(rays.oy[i]);
      r.org_z[i] = static_cast<float>(rays.oz[i]);
      r.dir_x[i] = static_cast<float>(rays.dx[i]);
      r.dir_y[i] = static_cast<float>(rays.dy[i]);
      r.dir_z[i] = static_cast<float>(rays.dz[i]);
      r.tfar[i] = static_cast<float>(beams.maxRange);
      if (i < rays.count) {
        r.time[i] = firingFraction(
            beams, std::size_t{tile.ring} * beams.columns + tile.column + static_cast<std::size_t>(i), duration);
      }
      r.mask[i] = ~0u;
      r.id[i] = static_cast<unsigned>(i);
      packet.rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      packet.valid[i] = i < rays.count ? -1 : 0;
    }
    packets_.push_back(packet);
  }

  Worlds worlds_;
  std::vector<Packet> packets_;
};

// The processor time of the steps of scans.
class Steps {
 public:
  template <class Work>
  void time(const std::string& name, const Work& work) {
    const double begin = threadSeconds();
    work();
    for (auto& [own, seconds] : steps_) {
      if (own == name) {
        seconds += threadSeconds() - begin;
        return;
      }
    }
    steps_.emplace_back(name, threadSeconds() - begin);
  }
  const std::vector<std::pair<std::string, double>>& seconds() const { return steps_; }

 private:
  std::vector<std::pair<std::string, double>> steps_;
};

void runSteps(const ShotSetup& setup, const Shot& shot, ShotBuffers& b, Steps& steps) {
  steps.time("trace, with paths of light and the ego vehicle", [&] { traceShot(setup, shot, b.hits); });
  const Receiver& receiver = setup.receiver;
  steps.time("detection of echoes", [&] { detect(b.hits, shot, receiver.effects, receiver.materials, b.returns); });
  if (receiver.layout.reasons) b.returns.recordReasons();
  for (const ChosenEffect& effect : receiver.effects) {
    steps.time("effect " + std::string(effect.entry->name),
               [&] { effect->apply(b.hits, shot, receiver.materials, b.returns); });
  }
  steps.time("gathering of points", [&] { gather(b.hits, shot, b.returns, receiver.layout, nullptr, b.scan); });
}

void measure(const std::string& name, const std::vector<std::string>& overrides) {
  const std::string file = std::string(SCANMILL_SOURCE_DIR) + "/pipelines/" + name + ".yaml";
  const Plan plan = makePlan(readPipeline(file, overrides));
  const TemporaryFolder folder;
  GenerateOptions options;
  options.folder = folder.path() / "dataset";
  options.quiet = true;
  const GenerateSummary made = generate(plan, options);

  ShotSource source(plan);
  const Scene scene = source.load(0);
  const std::unique_ptr<Method> method = source.method(scene);
  const Recording recording(*method);
  Bare bare(scene);
  Steps steps;
  ShotBuffers buffers;
  double bareSeconds = 0;
  std::uint64_t rays = 0;
  for (std::size_t sequence = 0; sequence < plan.pipeline.sequences.size(); ++sequence) {
    for (std::uint32_t number = 0; number < plan.pipeline.sequences[sequence].frames; ++number) {
      const Frame frame = source.frame(sequence, number);
      for (const Shot& shot : frame.shots) {
        const ShotSetup setup = setupOf(plan, *frame.settings, scene, *method, shot.sensor);
        runSteps(setup, shot, buffers, steps);
        const ShotSetup recorded = setupOf(plan, *frame.settings, scene, recording, shot.sensor);
        traceShot(recorded, shot, buffers.hits);
        for (const Shot& traced : recording.take()) {
          bareSeconds += bare.secondsOf(traced);
          rays += traced.beams->size();
        }
      }
    }
  }

  const auto scans = static_cast<double>(plan.pipeline.frames());
  const double setUp = made.stages.at("setup");
  fmt::print("{}: {} frames, {:.2f} million beams, {:.2f} million rays\n", name, plan.pipeline.frames(),
             static_cast<double>(made.beams) * 1e-6, static_cast<double>(rays) * 1e-6);
  const auto row = [scans](const std::string& what, double seconds) {
    fmt::print("  {:<48} {:8.3f} s {:9.2f} ms a frame\n", what, seconds, 1e3 * seconds / scans);
  };
  for (const auto& [stage, seconds] : made.stages) row("stage " + stage, seconds);
  row("the whole process but for setup", made.processorSeconds - setUp);
  row("bare Embree, the same rays", bareSeconds);
  fmt::print("  {:<48} {:8.2f}\n", "the process but for setup over bare Embree",
             (made.processorSeconds - setUp) / bareSeconds);
  fmt::print("  {:<48} {:8.2f}\n", "tracing over bare Embree", made.stages.at("trace") / bareSeconds);
  for (const auto& [step, seconds] : steps.seconds()) row(step, seconds);
  std::fflush(stdout);
}

int run(int frames) {
  const ThreadLimit one(1);
  const std::string count = fmt::format("{}", frames);
  measure("quickstart", {"scenes.0.seeds=[2]", "splits=null", "trajectories.1.frames=" + count, "trajectories.0=null"});
  return 0;
}

}  // namespace
}  // namespace scanmill

int main(int count, char** arguments) {
  return scanmill::run(count > 1 ? std::atoi(arguments[1]) : 12);
}
