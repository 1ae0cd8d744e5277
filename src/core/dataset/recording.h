#pragma once

// A recording: the hits or the passes of a pipeline's shots, kept as EXR files, from which scans can be made again
// without the scene. A folder:
//
//   recording.json                              what is there; written last
//   street-s1-lane-000012.top.json              a shot: time, poses, images
//   street-s1-lane-000012.top.hits.exr          kind hits: passes/exr/hits_exr.h
//   street-s1-lane-000012.top.0.front.exr       kind passes: step and camera; passes/exr/pass_exr.h
//
// docs/recordings.md describes the JSON files, for those who write passes with a renderer of their own.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "scene/material.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

enum class RecordingKind { Hits, Passes };

std::string_view nameOf(RecordingKind kind);  // "hits", "passes"

// A stretch of a turn and the images drawn for it.
struct RecordedStep {
  std::uint32_t firstColumn = 0;
  std::uint32_t endColumn = 0;
  Pose worldFromRig;                // of the sensor when the images were drawn
  std::vector<std::string> images;  // files
};

// A sensor's turn in a sample.
struct RecordedShot {
  std::string sample;  // key
  std::string sensor;
  double time = 0;                    // s since the start of the sequence
  std::vector<Pose> worldFromSensor;  // see Shot
  std::string hits;                   // file; kind hits
  std::vector<RecordedStep> steps;    // kind passes
};

struct RecordedSequence {
  std::string scene;
  std::uint64_t seed = 1;
  std::string trajectory;
  std::uint32_t frames = 0;
  std::uint32_t materials = 0;  // index into Recording::materials
};

struct RecordedSensor {
  std::string name;
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;
  std::string beams;                      // see beamsHash(); empty: unknown
  std::optional<Pose> vehicleFromSensor;  // where it was mounted; unknown in recordings of others
};

// SHA-256 of where the beams start and point, and of the sensor's range limits: what hits depend on.
std::string beamsHash(const BeamTable& beams);

struct Recording {
  static constexpr int kSchemaVersion = 1;
  RecordingKind kind = RecordingKind::Hits;
  std::string programVersion;
  std::string method;  // that made it
  std::filesystem::path folder;
  Ontology ontology;  // without classes: whoever reads it must say
  std::vector<RecordedSensor> sensors;
  std::vector<RecordedSequence> sequences;
  std::vector<std::vector<Material>> materials;  // tables that Hits::material points into
  std::vector<std::string> modelled;

  // "street-s1-lane-000012" -> that shot, read from its file. Throws InputError.
  RecordedShot shot(const std::string& sample, const std::string& sensor) const;
};

// Throws InputError that names the file and what is wrong where.
Recording readRecording(const std::filesystem::path& folder, RecordingKind kind);

// What the folder says that it holds; none where there is no recording.
std::optional<RecordingKind> recordingIn(const std::filesystem::path& folder);

class RecordingWriter {
 public:
  // Creates the folder. One that holds files is an InputError, unless `overwrite` and they are all of a finished
  // recording that this program made.
  RecordingWriter(std::filesystem::path folder, bool overwrite);

  const std::filesystem::path& folder() const { return folder_; }
  // "street-s1-lane-000012.top.hits.exr": a file of a shot. From any thread.
  std::filesystem::path file(std::string_view sample, std::string_view sensor, std::string_view rest) const;
  // A shot whose images are written. From any thread.
  void add(const RecordedShot& shot);
  // Writes recording.json, last.
  void finish(const Recording& recording);

 private:
  std::filesystem::path folder_;
};

}  // namespace scanmill
