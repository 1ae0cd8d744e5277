#pragma once

// What a pipeline will do, known before the first ray.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/pipeline.h"
#include "scan/channels.h"
#include "scene/scene.h"

namespace scanmill {

class Plan {
 public:
  // Throws InputError where the scenes' ontologies differ, or a frame does not fit into this machine's memory.
  explicit Plan(Pipeline pipeline);

  const Pipeline& pipeline() const { return pipeline_; }
  Channels channels() const { return channels_; }  // what effects, columns and formats read
  const std::vector<std::shared_ptr<const BeamTable>>& beams() const { return beams_; }  // per sensor

  // Loads the scene of a sequence; textures only where a channel needs them.
  Scene loadScene(const Sequence& sequence) const;
  std::unique_ptr<Method> makeMethod(const Scene& scene) const;

  // The shots of a frame, one per sensor.
  std::vector<Shot> shots(std::size_t sequence, std::uint32_t frame) const;

  // One line each: what is computed and what is left out, and why.
  std::vector<std::string> modelled() const;

  // Upper bounds: what a frame takes while it is made, and the dataset's size.
  std::uint64_t bytesPerFrameInMemory() const;
  double estimatedDatasetBytes() const;
  // How many frames are made at a time: enough for all threads, but no more than half of the memory holds.
  std::size_t framesInFlight() const;

 private:
  Pipeline pipeline_;
  Channels channels_;
  std::vector<std::shared_ptr<const BeamTable>> beams_;
};

}  // namespace scanmill
