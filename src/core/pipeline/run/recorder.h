#pragma once

// Records what a run traces (hits) or renders (passes); render() renders passes without making scans.

#include <atomic>
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
#include "passes/pass_image.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"

namespace scanmill {

class Recorder {
 public:
  Recorder(const Plan& plan, RecordingKind kind) : plan_(plan), kind_(kind) {}

  // Prepares the folder of the recording; an empty path means that nothing is recorded. Throws InputError.
  void open(const std::filesystem::path& folder, bool overwrite);
  bool records() const { return writer_.has_value(); }

  // The following functions may be called from any thread.

  // Registers a sequence. Must be called before shots of the sequence are written. Does nothing for a sequence that is
  // registered already, or if nothing is recorded.
  void enter(std::size_t sequence, const Scene& scene, const Method& method);
  void writeHits(const Shot& shot, const Hits& hits);
  // Writes the images of one step and adds them to `record`. writePasses() adds a complete `record` to the recording.
  void writeStep(const PassStep& step, RecordedShot& record);
  void writePasses(const RecordedShot& record) { writer_->add(record); }

  void finish();
  // Returns the seconds spent on writing so far, under the names "write_hits" and "write_passes".
  StageSeconds stageSeconds() const { return clock_.seconds(); }

 private:
  const Plan& plan_;
  RecordingKind kind_;
  std::optional<RecordingWriter> writer_;
  // The facts about a sequence that enter() has registered.
  struct Entered {
    RecordedSequence record;
    std::vector<Material> materials;
    std::vector<ModelledItem> modelled;
  };
  std::mutex mutex_;
  Ontology ontology_;
  std::map<std::size_t, Entered> entered_;  // keys: indices in Pipeline::sequences
  StageClock clock_;
};

struct RenderOptions {
  std::filesystem::path folder;
  PassChoice passes{};
  bool overwrite = false;
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // may be null; once it is true, rendering stops with an Error
};

struct RenderSummary {
  std::uint64_t shots = 0;
  std::uint64_t images = 0;
  std::uint64_t bytes = 0;
  double seconds = 0;
  std::map<std::string, double> stages;
  std::vector<std::string> warnings;
};

// Renders and records the passes of all frames. Throws InputError if the pipeline's method renders no passes, and Error
// if the work fails.
RenderSummary render(const Plan& plan, const RenderOptions& options);

}  // namespace scanmill
