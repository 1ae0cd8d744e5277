#pragma once

// What a pipeline will do: a value, known before a scene is loaded and before the first ray.
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
  Channels channels;  // that are traced: what effects, columns, formats and recordings read

  // The columns that the scans have besides their positions: those asked for, without an intensity that no effect sets.
  ColumnSet columns() const;

  // Throws InputError where the method draws no passes that could be kept, or `method: auto` may choose one that does
  // not.
  void requirePasses() const;
  // Throws InputError where the method may fire several rays a beam: kept hits are images with a pixel a beam.
  void requireOneRay() const;

  // Upper bound of what a frame takes while it is made.
  std::uint64_t bytesPerFrameInMemory() const;
  // How many frames are made at a time: one for each thread, but no more than half of the memory holds.
  std::size_t framesInFlight() const;
  // What the program takes with scenes of so many bytes, as methods hold them, and the frames in flight.
  std::uint64_t bytesInMemory(std::uint64_t scenes) const;
  // Throws InputError where a scene of so many bytes, in the form that the method has made of it, and the frames in
  // flight take more memory than there is. `scene`: what messages call it.
  void checkMemory(std::uint64_t bytes, const std::string& scene) const;
};

// Makes the plan of a pipeline. `kept`: channels that are wanted besides those that the scans need, for a recording.
// Throws InputError where the scenes' ontologies differ, the method cannot do what the pipeline asks for, or a frame
// does not fit into this machine's memory.
Plan makePlan(Pipeline pipeline, Channels kept = {});

// Returns the plan with a setting in place of `method: auto`; the record says which it is and why. Throws InputError
// where the method cannot do what the pipeline asks for.
Plan settled(Plan plan, MethodChoice choice, MethodRecord record);

// Returns a line each: what is computed and what is left out, and why. `blocked`: of each sensor, the share of its rays
// that the own vehicle is in the way of; empty: there is no vehicle.
std::vector<std::string> modelled(const Plan& plan, std::span<const double> blocked);

}  // namespace scanmill
