// Measures what a graphics card is worth: particles on the card and on all cores of its machine, rays on these cores,
// and the depth camera, which draws on the card; scan by scan, and in whole datasets. Particles must give the same
// bytes.
//
//     bench_card PROGRAM FOLDER
//
// PROGRAM is scanmill, which draws the paper's chart. FOLDER gets card.json with all figures, card.txt with the table
// that is printed, and the chart, timing/rings.svg. The device is the one that SCANMILL_GL_DEVICE names, or the first
// card. Times are medians in milliseconds a scan.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "base/process.h"
#include "config/resources.h"
#include "gpu/compute.h"
#include "gpu/device.h"
#include "pipeline/run/generate.h"
#include "tests/benchmarks/street_beams.h"
#include "tests/benchmarks/timing.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Scans with labels and intensity read these channels: 20 bytes a ray come back from a device.
constexpr Channels kLabelled = Channels(Channel::Range) | Channel::Instance | Channel::Semantic | Channel::Material |
                               Channel::Reflectance | Channel::Incidence;
constexpr double kSeconds = 0.4;           // that each figure is measured for, but for those of very slow devices
constexpr std::size_t kFewest = 3;         // runs
constexpr std::size_t kMostInFlight = 64;  // shots

Json figures = Json::object();
std::string table;
fs::path output;  // folder of the figures
int others = 0;   // scans and datasets whose bytes differ
int rounds = 2;   // that each dataset is made

template <class... Parts>
void print(fmt::format_string<Parts...> text, Parts&&... parts) {
  const std::string line = fmt::format(text, std::forward<Parts>(parts)...);
  std::fputs(line.c_str(), stdout);
  std::fflush(stdout);
  table += line;
}

double rounded(double value) {
  return std::stod(fmt::format("{:.4g}", value));
}

// The seconds of each run, after one that is not measured. What devices take after that first run is counted anew.
std::vector<double> measured(const std::function<void()>& work) {
  work();
  takeDeviceSeconds();
  std::vector<double> seconds;
  double all = 0;
  while (seconds.size() < kFewest || all < kSeconds) {
    seconds.push_back(secondsOf(work));
    all += seconds.back();
  }
  return seconds;
}

bool same(const Hits& a, const Hits& b) {
  return a.range == b.range && a.instance == b.instance && a.semantic == b.semantic && a.material == b.material &&
         a.reflectance == b.reflectance && a.incidence == b.incidence && a.unresolved == b.unresolved;
}

// The seconds of a scan where all threads trace shots of their own, as datasets are made; one after the other each
// takes `alone`.
double inFlight(const Method& method, const Shot& shot, double alone) {
  const auto threads = static_cast<std::size_t>(threadCount());
  const std::size_t shots = std::max(threads, std::min(kMostInFlight, static_cast<std::size_t>(kSeconds / alone)));
  const auto all = [&] {
    parallelFor(shots, 1, [&](std::size_t first, std::size_t last) {
      Hits hits;
      for (std::size_t i = first; i < last; ++i) method.trace(shot, kLabelled, hits);
    });
  };
  all();
  return median(secondsOfEach(3, all)) / static_cast<double>(shots);
}

struct Timing {
  double alone = 0;     // s, one scan after the other
  double inFlight = 0;  // s a scan
};

Timing timed(const std::string& name, const Method& method, const Shot& shot, Hits& hits) {
  TraceAccount account;
  bool warm = false;  // the first scan, which builds fields and compiles shaders, does not count
  const std::vector<double> seconds = measured([&] {
    const TraceAccount one = method.trace(shot, kLabelled, hits);
    if (warm) account += one;
    warm = true;
  });
  const auto scans = static_cast<double>(seconds.size());
  const StageSeconds programs = takeDeviceSeconds();
  Timing made{median(seconds)};
  made.inFlight = inFlight(method, shot, made.alone);
  Json row{
      {"beams", shot.beams->size()}, {"ms", rounded(1e3 * made.alone)}, {"in_flight_ms", rounded(1e3 * made.inFlight)}};
  std::string stages;
  const auto add = [&](const char* key, const StageSeconds& of, double runs) {
    for (const auto& [stage, sum] : of) {
      const double ms = 1e3 * sum / runs;
      row[key][stage] = rounded(ms);
      stages += fmt::format("{}{} {:.3g}", stages.empty() ? "" : ", ", stage, ms);
    }
  };
  add("device_ms", programs, scans);
  if (programs.empty()) add("stage_ms", account.seconds, scans);
  print("{:<42} {:>9.3f} {:>9.3f}  {}\n", name, 1e3 * made.alone, 1e3 * made.inFlight, stages);
  figures["scans"][name] = row;
  return made;
}

// The same particles on the card and on the processor.
void compareParticles(const Scene& scene, const std::string& refine, std::int64_t rings) {
  const std::string options = "{refine: " + refine + ", backend: ";
  const std::string name = fmt::format("particles, {}, {} x 2048", refine, rings);
  const Shot shot = streetShot(streetBeams(rings), -20);
  Hits there;
  Hits here;
  const Timing card = timed(name + ", card", *methodOf("particle", scene, options + "gl}"), shot, there);
  const Timing cores = timed(name + ", cores", *methodOf("particle", scene, options + "cpu}"), shot, here);
  const bool equal = same(there, here);
  if (!equal) others += 1;
  figures["scans"][name + ", card"]["same_bytes"] = equal;
  print("{:<42} {:>8.2f}x {:>8.2f}x  {} bytes\n", "", cores.alone / card.alone, cores.inFlight / card.inFlight,
        equal ? "same" : "OTHER");
}

void measureScans() {
  const Scene street = proceduralStreet();
  print("\nThe procedural street, {} triangles: milliseconds a scan with labels and reflectance\n",
        street.placedTriangles());
  print("{:<42} {:>9} {:>9}  stages (ms; of the card's programs by its own clock)\n", "", "alone", "in flight");
  Hits hits;
  for (const std::int64_t rings : {64, 512}) {
    const Shot shot = streetShot(streetBeams(rings), -20);
    timed(fmt::format("rays, {} x 2048, cores", rings), *rayTracing(street), shot, hits);
    timed(fmt::format("depth camera, {} x 2048, card", rings), *methodOf("depth_camera", street, "{layout: three_120}"),
          shot, hits);
  }
  for (const char* refine : {"none", "normal", "triangle"}) {
    for (const std::int64_t rings : {64, 512}) compareParticles(street, refine, rings);
  }
}

struct MadeDataset {
  double seconds = 0;
  double beams = 0;
  std::string digest;
  StageSeconds stages;
};

// A folder for one dataset, in memory where there is room, so that the disk is not measured; else beside the figures.
class DatasetFolder {
 public:
  explicit DatasetFolder(const fs::path& figuresFolder) {
    constexpr std::uintmax_t kRoom = std::uintmax_t{2} << 30;
    const fs::path memory = "/dev/shm";
    std::error_code failure;
    const fs::space_info space = fs::space(memory, failure);
    const bool roomy = !failure && space.available >= kRoom;
    path_ = (roomy ? memory : figuresFolder) / fmt::format("scanmill-card-{}", ::getpid());
  }
  ~DatasetFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  DatasetFolder(const DatasetFolder&) = delete;
  DatasetFolder& operator=(const DatasetFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

MadeDataset make(const std::string& pipeline, std::vector<std::string> set, const std::string& method) {
  const DatasetFolder folder(output);
  set.push_back("method=" + method);
  GenerateOptions options;
  options.folder = folder.path();
  options.quiet = true;
  MadeDataset made;
  made.seconds = secondsOf([&] {
    const Plan plan = makePlan(readPipeline(resourceFolder() / "pipelines" / pipeline, set));
    const GenerateSummary summary = generate(plan, options);
    for (const ShardRecord& shard : summary.manifest.shards) made.digest += shard.sha256;
    made.beams = static_cast<double>(summary.beams);
    made.stages = summary.stages;
  });
  made.digest = sha256(made.digest);
  return made;
}

// Makes a dataset by each method, twice in turn on a card, where the faster counts.
void compareDatasets(const std::string& name, const std::string& pipeline, const std::vector<std::string>& set,
                     const std::vector<std::string>& methods) {
  std::vector<MadeDataset> best(methods.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < methods.size(); ++k) {
      MadeDataset made = make(pipeline, set, methods[k]);
      if (round == 0 || made.seconds < best[k].seconds) best[k] = std::move(made);
    }
  }
  for (std::size_t k = 0; k < methods.size(); ++k) {
    const MadeDataset& made = best[k];
    double all = 0;
    for (const auto& [stage, seconds] : made.stages) all += seconds;
    std::string shares;
    Json row{{"seconds", rounded(made.seconds)},
             {"million_beams_per_second", rounded(1e-6 * made.beams / made.seconds)}};
    for (const auto& [stage, seconds] : made.stages) {
      row["stages"][stage] = rounded(seconds);
      if (seconds > 0.01 * all)
        shares += fmt::format("{}{} {:.0f} %", shares.empty() ? "" : ", ", stage, 100 * seconds / all);
    }
    row["sha256"] = made.digest;
    if (k > 0 && methods[k].find("backend: cpu") != std::string::npos && made.digest != best[k - 1].digest) {
      others += 1;
      shares += "  OTHER bytes than on the card";
    }
    figures["datasets"][name][methods[k]] = row;
    print("{:<20} {:<46} {:>7.2f}  {}\n", k == 0 ? name : "", methods[k], made.seconds, shares);
  }
}

void measureDatasets() {
  const std::string none = "{particle: {refine: none, backend: gl}}",
                    noneHere = "{particle: {refine: none, backend: cpu}}";
  const std::string all = "{particle: {backend: gl}}", allHere = "{particle: {backend: cpu}}";
  const std::string camera = "{depth_camera: {layout: three_120}}";
  const std::vector<std::string> drive{"scenes.0.seeds=[1]", "splits=", "trajectories.0.every_m=0.5",
                                       "trajectories.0.frames=100"};
  std::vector<std::string> stand = drive;
  stand.insert(stand.end(), {"trajectories.0.speed=0.01", "trajectories.0.every_m=0.0005"});
  print("\nWhole datasets, set-up included: seconds, and the shares of stages in the time of all threads\n");
  compareDatasets("street, driving", "street.yaml", drive, {"ray_tracing", camera, none, noneHere, all, allHere});
  compareDatasets("street, standing", "street.yaml", stand, {"ray_tracing", camera, none, noneHere, all, allHere});
  compareDatasets("quickstart.yaml", "quickstart.yaml", {}, {"ray_tracing"});
}

// The paper's chart: time a scan by the number of rings.
void drawChart(const fs::path& program) {
  const fs::path pipeline = resourceFolder() / "pipelines/paper/timing.yaml";
  const char* settings =
      "tradeoff.settings=[ray_tracing, {depth_camera: {layout: three_120}}, {particle: {refine: none, backend: cpu}}, "
      "{particle: {refine: none, backend: gl}}]";
  constexpr double kPatience = 600;  // s
  Process child({program, "tradeoff", pipeline, "--overwrite", "-o", output / "timing", "--set", settings});
  while (child.readLine(kPatience)) continue;
  if (const std::string end = child.wait(kPatience); end != "exit code 0") throw Error(end + ": " + child.lastLines());
  figures["chart"] = Json::parse(readFile(output / "timing/tradeoff.json")).at("rings");
  print("\nThe chart of time by rings: timing/rings.svg\n");
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "a processor";
}

void writeFigures() {
  writeFile(output / "card.json", figures.dump(1) + "\n");
  writeFile(output / "card.txt", table);
}

// Measures a part. If it fails, that is told, and the next parts are measured all the same.
void part(const char* what, const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    print("\n{} could not be measured: {}\n", what, error.what());
    figures["failed"][what] = error.what();
  }
  writeFigures();
}

int measure(const fs::path& program) {
  {
    const ComputeDevice device({"the card cannot be measured", "is its driver installed, with EGL and OpenGL 4.3?"});
    if (device.software() && namedDevice().empty()) {
      throw Error(
          fmt::format("there is no graphics card that can be used, only {}: install the card's driver with its "
                      "EGL library, or set SCANMILL_GL_DEVICE=software to measure this one",
                      device.name()));
    }
    if (device.software()) rounds = 1;
    figures["device"] = {{"name", device.name()}, {"driver", device.driver()}, {"software", device.software()}};
    print("{}\ndriver {}\nbeside {} threads of {}\n", device.nameAndPlace(), device.driver(), threadCount(),
          processor());
  }
  figures["processor"] = {{"name", processor()}, {"threads", threadCount()}};
  fs::create_directories(output);
  part("scans", measureScans);
  part("datasets", measureDatasets);
  part("the chart", [&] { drawChart(program); });
  const bool whole = !figures.contains("failed");
  print("\n{}{}\n",
        others == 0 ? "All bytes of particles are the processor's."
                    : fmt::format("{} times particles gave OTHER bytes than on the processor.", others),
        whole ? "" : " Not all could be measured: see above.");
  writeFigures();
  return others == 0 && whole ? 0 : 1;
}

}  // namespace
}  // namespace scanmill

int main(int count, char** words) {
  if (count != 3) {
    std::fputs("usage: bench_card PROGRAM FOLDER\n", stderr);
    return 2;
  }
  try {
    scanmill::output = words[2];
    return scanmill::measure(words[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
