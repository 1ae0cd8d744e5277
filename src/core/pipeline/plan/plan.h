#pragma once

// The plan of a pipeline: everything that the pipeline will do. A plan is made before a scene is loaded and before the
// first ray is traced.
//
//   const Plan plan = makePlan(readPipeline("pipelines/quickstart.yaml", {}));
//   const GenerateSummary made = generate(plan, {.folder = "out/quickstart"});   // pipeline/run/generate.h

#include <cstdint>
#include <memory>
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
  std::shared_ptr<const Footprint> footprint;  // the rays that sample a beam's width; null: each beam fires one ray
};

struct Plan {
  Pipeline pipeline;
  std::vector<PlannedSensor> sensors;
  Channels channels;  // channels to trace: those that effects, columns, formats and recordings read

  // Returns the scans' columns besides the position: the columns that the pipeline asks for, without intensity and
  // power if no effect sets them.
  ColumnSet columns() const;

  // Throws InputError unless each sample has exactly one revolution of each sensor, as recordings do.
  void requireOneRevolution() const;
  // Throws InputError if the method renders no passes, or like requireOneRevolution(). The pipeline must have a method.
  void requirePasses() const;
  // Throws InputError if a beam may need several rays, if there is an ego vehicle, or if mounts are random. Hits cannot
  // be recorded then, since a recording holds one ray per beam, the scene alone, and fixed mounts.
  void requireOneRay() const;

  // Returns an upper bound of the memory that a frame takes while it is computed (bytes).
  std::uint64_t bytesPerFrameInMemory() const;
  // Returns how many frames are computed at a time: one for each thread, or fewer if these do not fit into half of the
  // memory that the program leaves free, but at least one.
  std::size_t framesInFlight() const;
  // Returns the memory that the program takes in total while it computes framesInFlight() frames (bytes). `scenes`:
  // bytes of the loaded scenes, including what methods have built from them.
  std::uint64_t bytesInMemory(std::uint64_t scenes) const;
  // Throws InputError if a scene and framesInFlight() frames exceed the memory limit. `bytes`: size of the scene,
  // including what the method has built from it. `scene`: its name in messages.
  void checkMemory(std::uint64_t bytes, const std::string& scene) const;
};

// Makes the plan of a pipeline. `recorded`: channels that a recording saves beyond the channels that the scans need.
// Throws InputError if the plan cannot be carried out, for instance since the scenes' ontologies differ, the method
// cannot do what the pipeline asks for, or a frame exceeds the memory limit.
Plan makePlan(Pipeline pipeline, Channels recorded = {});

// Returns what is computed, what is left out, and why. `blocked`: for each sensor, the fraction of its rays that hit
// the ego vehicle; empty if there is no ego vehicle.
std::vector<ModelledItem> modelled(const Plan& plan, std::span<const double> blocked);
// Returns what the method models of a sequence's scene, what it leaves out, and how many parts are of glass.
std::vector<ModelledItem> modelledOf(const Plan& plan, const Sequence& sequence, const Scene& scene,
                                     const Method& method);

}  // namespace scanmill
