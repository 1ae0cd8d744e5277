#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include "base/file.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "pipeline/pipeline.h"
#include "pipeline/progress.h"
#include "scene/asset.h"
#include "scene/scene.h"
#include "sensors/sensor.h"

namespace scanmill {

namespace {

using Rows = std::vector<std::vector<std::string>>;

void printDataset(const std::filesystem::path& folder) {
  const Manifest m = readManifest(folder);
  fmt::print("dataset {}: {} samples, columns {}{}\n", m.name, m.samples.size(), fmt::join(m.columns, ", "),
             m.organised ? ", organised" : "");
  fmt::print("made by scanmill {}, seed {}\n\n", m.programVersion, m.seed);
  Rows shards{{"shard", "split", "samples", "size"}};
  for (const ShardRecord& s : m.shards) {
    shards.push_back({s.file, s.split, grouped(s.samples), shortBytes(static_cast<double>(s.bytes))});
  }
  fmt::print("{}\n", formatTable(shards));
  Rows sensors{{"sensor", "model", "rings", "columns", "method"}};
  for (const SensorRecord& s : m.sensors) {
    std::set<std::string> usedMethods;
    for (const SampleRecord& sample : m.samples) {
      for (const ScanRecord& scan : sample.scans) {
        if (scan.sensor == s.name) usedMethods.insert(scan.method);
      }
    }
    sensors.push_back({s.name, s.beams.model, std::to_string(s.beams.rings), std::to_string(s.beams.columns),
                       fmt::format("{}", fmt::join(usedMethods, ", "))});
  }
  fmt::print("{}\n", formatTable(sensors));
  std::map<std::uint16_t, std::uint64_t> perClass;
  std::uint64_t points = 0;
  std::uint64_t beams = 0;
  for (const SampleRecord& sample : m.samples) {
    for (const ScanRecord& scan : sample.scans) {
      points += scan.points;
      beams += scan.beams;
      for (const auto& [id, count] : scan.pointsPerClass) perClass[id] += count;
    }
  }
  Rows classes{{"class", "id", "points", "share"}};
  for (const auto& [id, count] : perClass) {
    const SemanticClass* c = m.ontology.find(id);
    classes.push_back({c == nullptr ? "?" : c->name, std::to_string(id), grouped(count),
                       percent(static_cast<double>(count), static_cast<double>(points))});
  }
  fmt::print("{}\n", formatTable(classes));
  fmt::print("{} points of {} beams ({})\n", grouped(points), grouped(beams),
             percent(static_cast<double>(points), static_cast<double>(beams)));
  for (const FormatRecord& f : m.formats) {
    fmt::print("format {} (.{}): {}\n", f.name, f.suffix,
               f.maxErrorMetres > 0 ? fmt::format("positions within {:.3g} mm", f.maxErrorMetres * 1000) : "lossless");
  }
  fmt::print("\nmodelled and left out:\n");
  for (const std::string& line : m.modelled) fmt::print("  {}\n", line);
}

struct Span {
  double low = INFINITY, high = -INFINITY;
  void add(double v) {
    if (std::isnan(v)) return;
    low = std::fmin(low, v);
    high = std::fmax(high, v);
  }
};

void printScan(const Scan& scan, const std::string& what) {
  fmt::print(
      "scan {}: {} points, {}\n\n", what, grouped(scan.size()),
      scan.organised ? fmt::format("organised {} rings x {} columns", scan.rings, scan.columns) : std::string("dense"));
  Rows rows{{"column", "min", "max"}};
  const auto add = [&](const char* name, std::size_t count, const std::function<double(std::size_t)>& at) {
    if (count == 0) return;
    Span span;
    for (std::size_t i = 0; i < count; ++i) span.add(at(i));
    rows.push_back({name, fmt::format("{:.6g}", span.low), fmt::format("{:.6g}", span.high)});
  };
  const std::size_t n = scan.size();
  add("x (m)", n, [&](std::size_t i) { return scan.position[i].x; });
  add("y (m)", n, [&](std::size_t i) { return scan.position[i].y; });
  add("z (m)", n, [&](std::size_t i) { return scan.position[i].z; });
  add("distance (m)", n, [&](std::size_t i) { return length(Vec3d(scan.position[i])); });
  add("intensity", scan.intensity.size(), [&](std::size_t i) { return scan.intensity[i]; });
  add("label", scan.label.size(), [&](std::size_t i) { return scan.label[i]; });
  add("instance", scan.instance.size(), [&](std::size_t i) { return scan.instance[i]; });
  add("ring", scan.ring.size(), [&](std::size_t i) { return scan.ring[i]; });
  add("column", scan.column.size(), [&](std::size_t i) { return scan.column[i]; });
  add("time (s)", scan.time.size(), [&](std::size_t i) { return scan.time[i]; });
  add("range_true (m)", scan.rangeTrue.size(), [&](std::size_t i) { return scan.rangeTrue[i]; });
  fmt::print("{}", formatTable(rows));
}

void printShard(const std::filesystem::path& file) {
  Rows rows{{"member", "bytes", "points"}};
  readTar(file, [&](const std::string& name, std::string_view bytes) {
    const std::size_t dot = name.rfind('.');
    const bool scan = dot != std::string::npos && formatBySuffix(name.substr(dot + 1)) != nullptr;
    const std::string place = file.string() + ": " + name;
    rows.push_back({name, grouped(bytes.size()), scan ? grouped(decodeMember(place, bytes).size()) : ""});
  });
  fmt::print("shard {}\n\n{}", file.string(), formatTable(rows));
}

void printScene(const std::filesystem::path& file) {
  const Scene scene = readScene(file, {});
  const Box box = scene.bounds();
  fmt::print("scene {}: {} triangles in memory, {} placed; {} instances, {} things\n", scene.name,
             grouped(scene.triangles()), grouped(scene.placedTriangles()), grouped(scene.instances.size()),
             grouped(scene.things()));
  fmt::print("from [{:.2f}, {:.2f}, {:.2f}] to [{:.2f}, {:.2f}, {:.2f}] m; ontology {}\n", box.low.x, box.low.y,
             box.low.z, box.high.x, box.high.y, box.high.z, scene.ontology.name);
  if (scene.dropped.total() > 0) {
    fmt::print("dropped triangles: {} degenerate, {} with NaN or infinite corners, {} with indices out of range\n",
               grouped(scene.dropped.degenerate), grouped(scene.dropped.nonFinite), grouped(scene.dropped.outOfRange));
  }
  struct PerClass {
    std::uint64_t triangles = 0;
    std::set<std::uint32_t> instances;
  };
  std::map<std::uint16_t, PerClass> perClass;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const std::uint16_t s : mesh.surfaceOf) ++perClass[mesh.surfaces[s].semantic].triangles;
    for (const Surface& s : mesh.surfaces) {
      if (s.object != 0) perClass[s.semantic].instances.insert(instanceId(instance, s));
    }
  }
  Rows rows{{"class", "id", "triangles", "instances"}};
  for (const auto& [id, c] : perClass) {
    const SemanticClass* known = scene.ontology.find(id);
    rows.push_back({known == nullptr ? "?" : known->name, std::to_string(id), grouped(c.triangles),
                    c.instances.empty() ? "" : grouped(c.instances.size())});
  }
  fmt::print("\n{}", formatTable(rows));
  Rows materials{{"material", "reflectance", "roughness", "metallic", "texture", "source"}};
  for (const Material& m : scene.materials) {
    materials.push_back({m.name, fmt::format("{:.3f}", m.reflectance), fmt::format("{:.2f}", m.roughness),
                         fmt::format("{:.0f}", m.metallic),
                         m.texture == nullptr ? ""
                         : m.alphaTested      ? "alpha"
                                              : "colour",
                         m.source});
  }
  fmt::print("\n{}", formatTable(materials));
}

void printSensor(const Value& value) {
  const auto beams = makeBeams(value);
  fmt::print("sensor {}: {} rings x {} columns, {:.3g} turns/s, {}, ring 0 is the {} beam\nsource: {}\n", beams->model,
             beams->rings, beams->columns, 1 / beams->period, beams->clockwise ? "clockwise" : "counter-clockwise",
             beams->topDown ? "top" : "bottom", beams->source);
  fmt::print("range {:.3g} to {:.3g} m; column 0 at {:.2f} deg; beams start {:.2f} mm off the axis\n\n",
             beams->minRange, beams->maxRange, degrees(beams->firstAzimuth), beams->originOffset * 1000);
  Rows rows{{"ring", "elevation deg", "azimuth offset deg", "firing us"}};
  for (std::uint32_t r = 0; r < beams->rings; ++r) {
    const auto at = [&](const std::vector<double>& column) { return r < column.size() ? column[r] : 0.0; };
    rows.push_back({std::to_string(r), fmt::format("{:.3f}", degrees(at(beams->elevation))),
                    fmt::format("{:.3f}", degrees(at(beams->azimuthOffset))),
                    fmt::format("{:.3f}", at(beams->firingOffset) * 1e6)});
  }
  fmt::print("{}", formatTable(rows));
}

void printAsset(const std::filesystem::path& file) {
  AssetOptions options;
  options.textures = false;
  const Asset asset = readAsset(file, options);
  Rows rows{{"node", "material", "texture", "triangles"}};
  std::uint64_t triangles = 0;
  for (const AssetPart& part : asset.parts) {
    rows.push_back({part.node, part.material, part.texture, grouped(part.triangles.size())});
    triangles += part.triangles.size();
  }
  fmt::print("asset {}: {} triangles; rules of a scene match these names\n\n{}", file.string(), grouped(triangles),
             formatTable(rows));
}

void printYaml(const std::filesystem::path& file) {
  const Value value = readYaml(file);
  if (value.find("objects") != nullptr) return printScene(file);
  if (value.find("elevation_deg") != nullptr) return printSensor(value);
  if (value.find("sensors") != nullptr) {
    const std::vector<std::string> plan{file.string()};
    runPlan(plan);
    return;
  }
  if (value.find("classes") != nullptr) {
    Rows rows{{"id", "class", "kind", "colour"}};
    for (const SemanticClass& c : readOntology(file).classes) {
      rows.push_back({std::to_string(c.id), c.name, c.thing ? "thing" : "stuff",
                      fmt::format("#{:02x}{:02x}{:02x}", c.color[0], c.color[1], c.color[2])});
    }
    fmt::print("{}", formatTable(rows));
    return;
  }
  throw InputError({file.string()},
                   "is neither a scene (objects), a sensor (elevation_deg), a pipeline (sensors) nor an "
                   "ontology (classes)");
}

}  // namespace

int runInfo(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("info");
  cxxopts::Options options = describe(command);
  const Arguments parsed = parseArguments(command, options, arguments,
                                          "  scanmill info out/quickstart\n"
                                          "  scanmill info out/quickstart/train/train-000000.tar\n"
                                          "  scanmill info scenes/street.yaml\n"
                                          "  scanmill info pipelines/sensors/os1_128.yaml\n"
                                          "  scanmill info model.glb       # names that labelling rules can match\n");
  if (parsed.help) return 0;
  const std::filesystem::path file = parsed.positional("FILE|DIR");
  std::string suffix = file.extension().string();
  if (!suffix.empty()) suffix.erase(0, 1);
  std::error_code failure;
  if (!std::filesystem::exists(file, failure)) {
    throw InputError({file.string()}, failure ? "cannot be read: " + failure.message() : "does not exist");
  }
  if (std::filesystem::is_directory(file)) {
    printDataset(file);
  } else if (file.filename() == "manifest.json") {
    printDataset(file.parent_path());
  } else if (suffix == "tar") {
    printShard(file);
  } else if (suffix == "yaml" || suffix == "yml") {
    printYaml(file);
  } else if (formatBySuffix(suffix) != nullptr) {
    printScan(decodeMember(file.string(), readFile(file)), file.string());
  } else {
    printAsset(file);
  }
  return 0;
}

}  // namespace scanmill
