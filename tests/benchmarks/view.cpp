// The viewer without a window, 1600 x 900: scans of the procedural street of 64 x 2048 beams, and 40 of them as one
// scan of 5 million points. Times are medians in milliseconds; `of_whole` compares with a picture of all points,
// `of_scan` with the same of 131,072 points, in one run.

#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "base/file.h"
#include "formats/format.h"
#include "sense/sense.h"
#include "tests/benchmarks/street_beams.h"
#include "tests/benchmarks/timing.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"
#include "tests/support/temporary_folder.h"
#include "viewer/window/session.h"

namespace scanmill {
namespace {

constexpr int kWidth = 1600;
constexpr int kHeight = 900;

Scan streetScan() {
  const Scene street = proceduralStreet();
  const Shot shot = streetShot(streetBeams(64), -20);
  Hits hits;
  rayTracing(street)->trace(
      shot, Channels(Channel::Range) | Channel::Semantic | Channel::Instance | Channel::Reflectance, hits);
  Returns returns;
  Scan scan;
  sense({.materials = street.materials}, hits, shot, returns, scan);
  return scan;
}

// So many turns of the scan, each a little larger.
Scan repeated(const Scan& scan, int times) {
  Scan many;
  many.rings = scan.rings;
  many.columns = scan.columns;
  for (int k = 0; k < times; ++k) {
    for (const Vec3f& p : scan.position) many.position.push_back(p * (1 + 0.0007F * static_cast<float>(k)));
    visitTable(scan,
               [&](auto key, const auto& values) { many[key].insert(many[key].end(), values.begin(), values.end()); });
  }
  return many;
}

const std::filesystem::path& scanFile(int times) {
  static const TemporaryFolder folder;
  static std::map<int, std::filesystem::path> files;
  std::filesystem::path& file = files[times];
  if (file.empty()) {
    static const Scan scan = streetScan();
    const Value none = parseYaml("{}", "options");
    Fields options(none, "format");
    file = folder.write("scan" + std::to_string(times) + ".pcd",
                        formatBySuffix("pcd")->make(options)->encode(times == 1 ? scan : repeated(scan, times)));
  }
  return file;
}

struct Viewer {
  explicit Viewer(int times)
      : canvas(openOffscreen(kWidth, kHeight)), session(openFrames({.path = scanFile(times)}), *canvas, {}) {
    session.settle();
  }

  void send(CanvasEvent::Kind kind, int x, int y, const std::string& key = "") {
    CanvasEvent event{.kind = kind, .x = x, .y = y, .button = 1};
    event.key = event.text = key;
    session.handle(event);
  }

  std::unique_ptr<Canvas> canvas;
  ViewSession session;
};

// From nothing to a whole picture; the module is loaded and its shaders are made in the first run alone.
void open(benchmark::State& state) {
  const int times = static_cast<int>(state.range(0));
  scanFile(times);
  for (auto _ : state) state.SetIterationTime(secondsOf([&] { const Viewer viewer(times); }));
}

void whole(benchmark::State& state) {
  Viewer viewer(static_cast<int>(state.range(0)));
  int step = 0;
  for (auto _ : state) {
    OrbitCamera camera = viewer.session.camera();
    camera.yaw += ++step % 2 != 0 ? 0.01 : -0.01;
    viewer.session.setCamera(camera);
    state.SetIterationTime(secondsOf([&] { viewer.session.settle(); }));
  }
}

// A drag: what is drawn while the pointer moves.
void moving(benchmark::State& state) {
  Viewer viewer(static_cast<int>(state.range(0)));
  OrbitCamera camera = viewer.session.camera();
  camera.yaw += 0.01;
  viewer.session.setCamera(camera);
  const double all = secondsOf([&] { viewer.session.settle(); });
  viewer.send(CanvasEvent::Kind::Move, 800, 500);
  viewer.send(CanvasEvent::Kind::Down, 800, 500);
  int step = 0;
  const auto move = [&] {
    ++step;
    viewer.send(CanvasEvent::Kind::Move, 800 + step % 200, 500);
    viewer.send(CanvasEvent::Kind::Tick, 800 + step % 200, 500);
  };
  for (int i = 0; i < 5; ++i) move();  // it learns how many points are drawn in time
  std::vector<double> seconds;
  for (auto _ : state) {
    seconds.push_back(secondsOf(move));
    state.SetIterationTime(seconds.back());
  }
  state.counters["of_whole"] = median(seconds) / all;
}

void pointing(benchmark::State& state) {
  Viewer viewer(static_cast<int>(state.range(0)));
  int x = 600;
  for (auto _ : state) state.SetIterationTime(secondsOf([&] { viewer.session.pick(++x, 520); }));
}

// All points get other colours.
void recolouring(benchmark::State& state) {
  Viewer viewer(static_cast<int>(state.range(0)));
  int step = 0;
  for (auto _ : state) {
    state.SetIterationTime(secondsOf([&] { viewer.send(CanvasEvent::Kind::Key, 0, 0, ++step % 2 != 0 ? "4" : "1"); }));
  }
}

void sizes(benchmark::internal::Benchmark* b) {
  b->Arg(1)->Arg(40)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(15);
}

BENCHMARK(open)
    ->Arg(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->Name("open/first in the process");
BENCHMARK(open)->Apply(sizes);
BENCHMARK(whole)->Apply(sizes);
BENCHMARK(moving)->Apply(sizes);
BENCHMARK(pointing)->Apply(sizes);
BENCHMARK(recolouring)->Apply(sizes);

}  // namespace
}  // namespace scanmill
