#pragma once

// A recording: the hits or the passes of a pipeline's shots, stored as EXR files, from which scans can be generated
// again without the scene. This header is installed because pipeline/read/pipeline.h includes it.
//
//   const auto recording = std::make_shared<const Recording>(readRecording("hits", RecordingKind::Hits));
//   const Pipeline pipeline = readPipeline("pipelines/street.yaml", {}, recording);
//
// A folder:
//
//   recording.json                              index of the recording; written last
//   street-s1-lane-000012.top.json              a shot: time, poses, images
//   street-s1-lane-000012.top.hits.exr          hits of the shot (kind hits), see passes/exr/hits_exr.h
//   street-s1-lane-000012.top.0.front.exr       image of a step and a camera (kind passes), see passes/exr/pass_exr.h
//
// docs/recordings.md describes the JSON files, for users who render passes with another program.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "scan/modelled_item.h"
#include "scene/material.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

enum class RecordingKind { Hits, Passes };

std::string_view nameOf(RecordingKind kind);  // Returns "hits" or "passes".

// Consecutive columns of a revolution, [firstColumn, endColumn), and the images that were rendered for them.
struct RecordedStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;                // pose of the sensor from which the images were rendered
  std::vector<std::string> images;  // file names of the images
};

// A revolution of a sensor in a sample.
struct RecordedShot {
  std::string sample;  // key of the sample
  std::string sensor;
  double time = 0;                    // s since the start of the sequence
  std::vector<Pose> worldFromSensor;  // poses of the sensor, see Shot::worldFromSensor
  std::string hits;                   // name of the file with the hits; used only by RecordingKind::Hits
  std::vector<RecordedStep> steps;    // steps of the revolution; used only by RecordingKind::Passes
};

struct RecordedSequence {
  std::string scene;
  std::uint64_t seed = 1;
  std::string trajectory;
  std::uint32_t frames = 0;
  std::uint32_t materials = 0;            // index into Recording::materials
  std::vector<std::string> without = {};  // classes, and names and ids of objects, removed from the scene: "car", "17"
};

struct RecordedSensor {
  std::string name;
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;
  std::string beams;                      // hash of the beams, see beamsHash(); empty: unknown
  std::optional<Pose> vehicleFromSensor;  // mounting pose; may be unknown in recordings by other programs
};

// Returns the SHA-256 of the properties of beams that determine hits: origins, directions and range limits.
std::string beamsHash(const BeamTable& beams);

struct Recording {
  static constexpr int kSchemaVersion = 1;
  RecordingKind kind = RecordingKind::Hits;
  std::string programVersion{};
  std::string method{};  // name of the method that computed the hits or passes
  std::filesystem::path folder{};
  Ontology ontology{};  // has no classes if the recording has no ontology; the pipeline must then name one
  std::vector<RecordedSensor> sensors{};
  std::vector<RecordedSequence> sequences{};
  std::vector<std::vector<Material>> materials{};  // tables of materials, each indexed by Hits::material
  std::vector<ModelledItem> modelled{};

  // Reads the JSON file of a shot. `sample`: a key such as "street-s1-lane-000012". Throws InputError.
  RecordedShot shot(const std::string& sample, const std::string& sensor) const;
};

// Reads recording.json in a folder. Throws an InputError that names the file, the place in it, and the problem; one
// possible problem is that the recording is not of the kind `kind`.
Recording readRecording(const std::filesystem::path& folder, RecordingKind kind);

// Returns the kind of the recording in a folder; nothing if the folder has no recording.
std::optional<RecordingKind> recordingIn(const std::filesystem::path& folder);

class RecordingWriter {
 public:
  // Creates the folder. If the folder contains files, removes them if `overwrite` is true and all of them belong to a
  // finished recording by this program; otherwise throws InputError.
  RecordingWriter(std::filesystem::path folder, bool overwrite);

  const std::filesystem::path& folder() const { return folder_; }
  // Returns the path "<sample>.<sensor>.<ending>" in the folder. `ending`: such as "hits.exr". Safe on any thread.
  std::filesystem::path file(std::string_view sample, std::string_view sensor, std::string_view ending) const;
  // Writes the JSON file of a shot whose images have been written. May be called from any thread.
  void add(const RecordedShot& shot);
  // Writes recording.json; must be the last call.
  void finish(const Recording& recording);

 private:
  std::filesystem::path folder_;
};

}  // namespace scanmill
