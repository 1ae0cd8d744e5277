#pragma once

// Writes what a run traces as recordings: hits, passes, both or none.

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/recording.h"
#include "methods/depth_camera/depth_camera.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"

namespace scanmill {

// Channels that a recording of hits holds besides those that the run's own scans need: all that effects and columns of
// another run may read.
Channels recordedChannels();

class Recorder {
 public:
  explicit Recorder(const Plan& plan) : plan_(plan) {}

  // Prepares the folders that are not empty paths. Throws InputError.
  void open(const std::filesystem::path& hits, const std::filesystem::path& passes, bool overwrite);
  bool recordsHits() const { return hits_.has_value(); }
  bool recordsPasses() const { return passes_.has_value(); }

  // All of these from any thread.

  // Shots of this sequence follow; it may be entered again.
  void enter(std::size_t sequence, const Scene& scene, const Method& method);
  void writeHits(const Shot& shot, const Hits& hits);
  // The record of a shot's passes: its steps are written one after the other, then the record itself.
  static RecordedShot beginPasses(const Shot& shot);
  void writeStep(const PassStep& step, RecordedShot& record);
  void writePasses(const RecordedShot& record);

  void finish();
  // Of writing so far: "write_hits" and "write_passes", those that are recorded.
  StageSeconds stageSeconds() const { return clock_.seconds(); }

 private:
  Recording describe(RecordingKind kind) const;

  const Plan& plan_;
  std::optional<RecordingWriter> hits_;
  std::optional<RecordingWriter> passes_;
  // What is known of a sequence that was entered.
  struct Entered {
    RecordedSequence record;
    std::vector<Material> materials;
    std::vector<std::string> modelled;
  };
  std::mutex mutex_;
  Ontology ontology_;
  std::map<std::size_t, Entered> entered_;  // by their numbers in the pipeline
  StageClock clock_;
};

}  // namespace scanmill
