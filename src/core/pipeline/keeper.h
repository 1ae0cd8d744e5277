#pragma once

// Keeps what a run traces as recordings: hits, passes, both or none.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/stage_clock.h"
#include "dataset/recording.h"
#include "methods/depth_camera/depth_camera.h"
#include "pipeline/plan.h"
#include "scan/hits.h"

namespace scanmill {

// Channels that a recording of hits holds besides those that the run's own scans need: all that effects and columns of
// another run may read.
Channels keptChannels();

class Keeper {
 public:
  explicit Keeper(const Plan& plan) : plan_(plan) {}

  // Prepares the folders that are not empty paths. Throws InputError.
  void open(const std::filesystem::path& hits, const std::filesystem::path& passes, bool overwrite);
  // From now on shots are of this sequence; scene and method live until leave(). Where passes are to be kept, the
  // method draws them: Plan::requirePasses().
  void enter(std::size_t sequence, const Scene& scene, const Method& method);
  void leave();

  bool keeps() const { return hits_.has_value() || passes_.has_value(); }
  bool keepsPasses() const { return passes_.has_value(); }
  // Keeps the hits; where passes are kept, draws them first, keeps them and samples the hits from them. From any
  // thread. The account is the method's.
  TraceAccount keep(const Shot& shot, Channels channels, Hits& hits);
  // Draws and keeps the shot's passes alone.
  TraceAccount keepPasses(const Shot& shot, PassChoice choice, const std::function<void(const PassStep&)>& use = {});
  void finish();
  // Of writing so far: "write_hits" and "write_passes", those that are kept.
  StageSeconds stageSeconds() const { return clock_.seconds(); }

 private:
  Recording describe(RecordingKind kind) const;

  const Plan& plan_;
  std::optional<RecordingWriter> hits_;
  std::optional<RecordingWriter> passes_;
  const DepthCamera* camera_ = nullptr;
  Ontology ontology_;
  std::vector<RecordedSequence> sequences_;
  std::vector<std::vector<Material>> materials_;
  std::vector<std::string> modelled_;
  StageClock clock_;
};

}  // namespace scanmill
