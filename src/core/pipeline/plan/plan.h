#pragma once

// The plan of a pipeline: all that it will do, known before a scene is loaded and before the first ray is traced.
//
//   const Plan plan = makePlan(readPipeline("pipelines/quickstart.yaml", {}));
//   const GenerateSummary made = generate(plan, {.folder = "out/quickstart"});   // pipeline/run/generate.h

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/read/pipeline.h"
#include "scan/channels.h"
#include "sensors/footprint.h"

namespace scanmill {

struct PlannedSensor {
  std::shared_ptr<const BeamTable> beams;
  std::shared_ptr<const Footprint> footprint;  // the rays of its beams; null: each fires one
};

struct Plan {
  Pipeline pipeline;
  std::optional<MethodRecord> chosen;  // how `method: auto` was settled
  std::vector<PlannedSensor> sensors;
  Channels channels;  // to be traced: those that effects, columns, formats and recordings read

  // Returns the columns that the scans have besides their positions: those that the pipeline asks for, without the
  // intensity if no effect sets it.
  ColumnSet columns() const;

  // Throws InputError if the method renders no passes that could be saved, or if `method: auto` may choose such a
  // method.
  void requirePasses() const;
  // Throws InputError if beams may fire several rays, if there is an own vehicle, or if mounts are random. Hits and
  // passes can then not be saved, since they are images of the scene alone, with one ray per beam.
  void requireOneRay() const;

  // Returns an upper bound of the bytes of a frame while it is computed.
  std::uint64_t bytesPerFrameInMemory() const;
  // Returns how many frames are computed at a time: one for each thread, but no more than fit into half of the memory.
  std::size_t framesInFlight() const;
  // Returns the bytes that the program takes in all, with frames in flight. `scenes`: bytes of the loaded scenes,
  // including what methods have built from them.
  std::uint64_t bytesInMemory(std::uint64_t scenes) const;
  // Throws InputError if a scene and the frames in flight take more memory than there is. `bytes`: size of the scene,
  // including what the method has built from it. `scene`: its name in messages.
  void checkMemory(std::uint64_t bytes, const std::string& scene) const;
};

// Makes the plan of a pipeline. `kept`: further channels that a recording saves, besides those that the scans need.
// Throws InputError if the scenes' ontologies differ, the method cannot do what the pipeline asks for, or a frame does
// not fit into this machine's memory.
Plan makePlan(Pipeline pipeline, Channels kept = {});

// Returns the plan with a method and its options in place of `method: auto`; the record says what was chosen and why.
// Throws InputError if the method cannot do what the pipeline asks for.
[[nodiscard]] Plan settled(Plan plan, MethodChoice choice, MethodRecord record);

// Returns lines that say what is computed, what is left out, and why. `blocked`: for each sensor, the share of its rays
// that the own vehicle blocks; empty: no own vehicle.
std::vector<std::string> modelled(const Plan& plan, std::span<const double> blocked);

}  // namespace scanmill
