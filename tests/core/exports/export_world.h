#pragma once

// Two sequences of two frames with one or two sensors, a car and a pedestrian, as layouts get them.

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "exports/layout.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

// Returns the bytes of all files in a folder and its subfolders, by their names relative to the folder.
inline std::map<std::string, std::string> filesIn(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(folder).generic_string()] = readFile(entry.path());
  }
  return files;
}

class ExportWorld : public testing::Test {
 protected:
  // `layout`: the layout that is tested. `labels`: see use().
  explicit ExportWorld(std::unique_ptr<ExportLayout> layout = nullptr, const std::string& labels = "")
      : layout_(std::move(layout)) {
    use(labels);
  }

  // Classes of scanmill.yaml, exported as those of labels/NAME.yaml; empty: as they are.
  void use(const std::string& labels) {
    const std::filesystem::path folder = std::filesystem::path(SCANMILL_SOURCE_DIR) / "labels";
    plan_.manifest = {};
    plan_.manifest.name = "world";
    plan_.manifest.ontology = readOntology(folder / "scanmill.yaml");
    const Ontology target = labels.empty() ? plan_.manifest.ontology : readOntology(folder / (labels + ".yaml"));
    plan_.classes = ClassMap(plan_.manifest.ontology, target);
    BeamTable beams;
    beams.model = "test";
    beams.rings = 4;
    beams.columns = 90;
    beams.period = 0.1;
    beams.minRange = 0.5;
    beams.maxRange = 100;
    plan_.manifest.columns = {"x", "y", "z", "intensity", "label", "instance", "ring", "column", "time", "range_true"};
    plan_.manifest.sensors = {{"top", beams, Pose{fromYawPitchRoll(0.1, 0, 0), {1.2, 0, 1.9}}},
                              {"rear", beams, Pose{fromYawPitchRoll(kPi, 0, 0), {-2, 0, 1}}}};
    plan_.manifest.samples.clear();
    plan_.sequences.clear();
    for (const char* name : {"street-s1-lane", "street-s2-lane"}) {
      ExportSequence sequence{name, plan_.sequences.empty() ? "train" : "val", {}};
      for (int frame = 0; frame < 2; ++frame) {
        SampleRecord sample;
        sample.key = std::string(name) + "-00000" + std::to_string(frame);
        sample.split = sequence.split;
        for (const SensorRecord& sensor : plan_.manifest.sensors) {
          ScanRecord scan;
          scan.sensor = sensor.name;
          scan.method = "ray_tracing";
          scan.time = 0.1 * frame;
          scan.beams = beams.size();
          scan.worldFromSensor = {vehicle(frame) * *sensor.vehicleFromSensor};
          sample.scans.push_back(scan);
        }
        sequence.samples.push_back(plan_.manifest.samples.size());
        plan_.manifest.samples.push_back(sample);
      }
      plan_.sequences.push_back(sequence);
    }
    plan_.sensors = {&plan_.manifest.sensors[0]};
  }

  void nameSensor(std::size_t number, const std::string& name) {
    plan_.manifest.sensors[number].name = name;
    for (SampleRecord& sample : plan_.manifest.samples) sample.scans[number].sensor = name;
  }

  void useBothSensors() { plan_.sensors = {&plan_.manifest.sensors[0], &plan_.manifest.sensors[1]}; }

  // Drives along x at 5 m/s, turned to the left by 0.2 rad.
  static Pose vehicle(int frame) { return {fromYawPitchRoll(0.2, 0, 0), {100 + 0.5 * frame, 20, 0.25}}; }

  // Points on a wall, the car (instance 7) and the pedestrian (instance 9); the last row of an organised scan is a
  // miss.
  Scan scan(std::size_t sensor, std::size_t frame, bool organised = false) const {
    Scan scan;
    scan.rings = 4;
    scan.columns = 90;
    scan.organised = organised;
    for (std::uint32_t i = 0; i < 360; ++i) {
      const bool miss = organised && i % 90 == 89;
      if (!organised && i % 7 == 0) continue;  // lost
      const double azimuth = radians(4.0 * (i % 90)) - kPi;
      const double range = 10 + 0.01 * i + static_cast<double>(frame) + static_cast<double>(sensor);
      const float none = std::numeric_limits<float>::quiet_NaN();
      scan.position.push_back(miss
                                  ? Vec3f{none, none, none}
                                  : Vec3f(Vec3d{range * std::cos(azimuth), range * std::sin(azimuth), 0.1 * (i / 90)}));
      scan[kIntensity].push_back(miss ? 0.0f : static_cast<float>(i) / 360);
      const std::uint32_t thing = miss ? 0 : i % 5 == 1 ? 7 : i % 5 == 2 ? 9 : 0;
      scan[kLabel].push_back(thing == 7 ? classId("car") : thing == 9 ? classId("pedestrian") : classId("building"));
      scan[kInstance].push_back(thing);
      scan[kRing].push_back(static_cast<std::uint16_t>(i / 90));
      scan[kColumn].push_back(static_cast<std::uint16_t>(i % 90));
      scan[kTime].push_back(static_cast<float>(i % 90) * 0.1f / 90);
      scan[kRangeTrue].push_back(miss ? none : static_cast<float>(range));
    }
    return scan;
  }

  std::uint16_t classId(const char* name) const { return plan_.manifest.ontology.require(name, {}).id; }

  // The car drives, the pedestrian stands.
  SampleObjects objects(std::size_t sequence, std::size_t frame) const {
    const SampleRecord& sample = plan_.manifest.samples[plan_.sequences[sequence].samples[frame]];
    SampleObjects all{sample.key, sample.scans[0].time, {}};
    for (const bool car : {true, false}) {
      ObjectRecord object;
      object.id = car ? 7 : 9;
      object.semantic = classId(car ? "car" : "pedestrian");
      object.name = car ? "car 7" : "walker";
      object.moves = car;
      object.worldFromBox = car ? Pose{fromYawPitchRoll(0.3, 0, 0), {115 + 0.8 * static_cast<double>(frame), 24, 1}}
                                : Pose{fromYawPitchRoll(-2, 0, 0), {111, 18, 1.1}};
      object.size = car ? Vec3d{4.5, 1.8, 1.5} : Vec3d{0.5, 0.6, 1.75};
      object.velocity = car ? Vec3d{8, 0, 0} : Vec3d{};
      for (const SensorRecord* sensor : plan_.sensors) {
        ObjectView view;
        view.sensor = sensor->name;
        view.time = all.time;
        view.sensorFromBox =
            inverse(vehicle(static_cast<int>(frame)) * *sensor->vehicleFromSensor) * object.worldFromBox;
        view.points = car ? 72 : 60;
        view.beams = car ? 72 : 60;
        view.beamsAlone = 100;
        view.nearestRange = 10.25;
        object.views.push_back(view);
      }
      all.objects.push_back(object);
    }
    return all;
  }

  ExportSample sample(std::size_t sequence, std::size_t frame, bool organised = false) const {
    ExportSample sample;
    sample.record = &plan_.manifest.samples[plan_.sequences[sequence].samples[frame]];
    sample.sequence = sequence;
    sample.frame = frame;
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      const auto number = static_cast<std::size_t>(plan_.sensors[s] - plan_.manifest.sensors.data());
      for (const ScanRecord* record : revolutionsOf(plan_, *sample.record, s)) {
        sample.scans.push_back({record, plan_.sensors[s], s, scan(number, frame, organised)});
      }
    }
    if (withObjects_) sample.objects = objects(sequence, frame);
    return sample;
  }

  // Writes all units and what is of the whole dataset. Gives what that warns of.
  std::vector<std::string> write(const ExportLayout& layout, bool organised = false) const {
    const ExportFolder folder(folder_.path());
    layout.check(plan_);
    const ReadSample read = [&](std::size_t s, std::size_t f) { return sample(s, f, organised); };
    for (std::size_t s = 0; s < plan_.sequences.size(); ++s) {
      checkSamples(layout, s, read);
      const std::size_t units = layout.bySequence() ? 1 : plan_.sequences[s].samples.size();
      for (std::size_t f = 0; f < units; ++f) layout.write(plan_, s, f, read, folder);
    }
    return layout.finish(
        plan_, [&](std::size_t s, std::size_t f) { return withObjects_ ? std::optional(objects(s, f)) : std::nullopt; },
        folder);
  }

  // Writes one unit, of samples that `change` has changed.
  template <class Change>
  void writeChanged(const ExportLayout& layout, std::size_t sequence, std::size_t frame, const Change& change,
                    bool organised = false) const {
    const ReadSample read = [&](std::size_t s, std::size_t f) {
      ExportSample changed = sample(s, f, organised);
      change(changed);
      return changed;
    };
    checkSamples(layout, sequence, read);
    layout.write(plan_, sequence, frame, read, ExportFolder(folder_.path()));
  }

  // Shows the layout all samples of a sequence, as an export does before it writes.
  void checkSamples(const ExportLayout& layout, std::size_t sequence, const ReadSample& read) const {
    for (std::size_t f = 0; layout.checksSamples(plan_) && f < plan_.sequences[sequence].samples.size(); ++f) {
      layout.checkSample(plan_, read(sequence, f));
    }
  }

  // Writes the sample as it is, in the layout that is tested.
  void writeSample(const ExportSample& sample) const {
    writeChanged(*layout_, sample.sequence, sample.frame, [&](ExportSample& changed) { changed = sample; });
  }

  // Returns the bytes of all files that were written, by their names.
  std::map<std::string, std::string> written() const { return filesIn(folder_.path()); }

  // Runs Python with numpy's module as `np`, `folder` and `json` at hand; gives what it prints.
  std::string python(const std::string& code) const {
    const std::filesystem::path script = scripts_.write(
        "script.py",
        "import json, pathlib, struct, sys\nimport numpy as np\nfolder = pathlib.Path(sys.argv[1])\n" + code);
    const std::filesystem::path out = scripts_.path() / "out";
    const std::string command =
        "/usr/bin/python3 '" + script.string() + "' '" + folder_.path().string() + "' > '" + out.string() + "' 2>&1";
    const int status = std::system(command.c_str());
    const std::string printed = readFile(out);
    EXPECT_EQ(status, 0) << printed;
    return printed;
  }

  std::unique_ptr<ExportLayout> layout_;
  ExportPlan plan_;
  bool withObjects_ = true;
  TemporaryFolder folder_;
  TemporaryFolder scripts_;
};

}  // namespace scanmill
