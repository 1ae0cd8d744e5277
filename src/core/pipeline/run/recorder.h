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

// Returns the channels that a recording of hits holds besides those that the run's own scans need: all channels that
// effects and columns of another run may read.
Channels recordedChannels();

class Recorder {
 public:
  explicit Recorder(const Plan& plan) : plan_(plan) {}

  // Prepares the folders whose paths are not empty. Throws InputError.
  void open(const std::filesystem::path& hits, const std::filesystem::path& passes, bool overwrite);
  bool recordsHits() const { return hits_.has_value(); }
  bool recordsPasses() const { return passes_.has_value(); }

  // The following calls are safe from any thread.

  // Must be called before shots of a sequence are written; further calls for the same sequence do nothing.
  void enter(std::size_t sequence, const Scene& scene, const Method& method);
  void writeHits(const Shot& shot, const Hits& hits);
  // Returns the record of a shot's passes. writeStep() adds its steps one after the other, writePasses() writes it.
  static RecordedShot beginPasses(const Shot& shot);
  void writeStep(const PassStep& step, RecordedShot& record);
  void writePasses(const RecordedShot& record);

  void finish();
  // Returns the time spent on writing so far: "write_hits" and "write_passes", as far as they are recorded.
  StageSeconds stageSeconds() const { return clock_.seconds(); }

 private:
  Recording describe(RecordingKind kind) const;

  const Plan& plan_;
  std::optional<RecordingWriter> hits_;
  std::optional<RecordingWriter> passes_;
  // The facts about a sequence that was entered.
  struct Entered {
    RecordedSequence record;
    std::vector<Material> materials;
    std::vector<std::string> modelled;
  };
  std::mutex mutex_;
  Ontology ontology_;
  std::map<std::size_t, Entered> entered_;  // by index in Pipeline::sequences
  StageClock clock_;
};

}  // namespace scanmill
