#pragma once

// What a pipeline will do, known before the first ray.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "pipeline/plan/frame_settings.h"
#include "pipeline/read/pipeline.h"
#include "scan/channels.h"
#include "scene/scene.h"
#include "sensors/footprint.h"

namespace scanmill {

// Makes the method that a pipeline or a study names; not `auto`, which names none. Throws InputError for what is wrong
// with the options.
std::unique_ptr<Method> makeMethod(const MethodChoice& choice, const Scene& scene);

class Plan {
 public:
  // `kept`: channels that are wanted besides those that the scans need, for a recording. Throws InputError where the
  // scenes' ontologies differ, the method cannot do what the pipeline asks for, or a frame does not fit into this
  // machine's memory.
  explicit Plan(Pipeline pipeline, Channels kept = {});

  const Pipeline& pipeline() const { return pipeline_; }
  Channels channels() const { return traced_; }  // what effects, columns, formats and recordings read
  const std::vector<std::shared_ptr<const BeamTable>>& beams() const { return beams_; }  // per sensor

  // The rays of a sensor's beams; null where each fires one.
  const Footprint* footprint(std::size_t sensor) const { return footprints_[sensor].get(); }

  // How the sensors stand and what runs on their scans, in the first frame of the first sequence; where nothing is
  // drawn, in all.
  const FrameSettings& settings() const { return settings_; }
  // In a certain frame. Throws InputError where what is drawn cannot be.
  std::shared_ptr<const FrameSettings> settings(std::size_t sequence, std::uint32_t frame) const;

  // Loads the scene of a sequence; textures only where a channel needs them. Of a recording: what scans need of its
  // scene, which is its classes and materials.
  Scene loadScene(const Sequence& sequence) const;
  std::unique_ptr<Method> makeMethod(const Scene& scene) const;

  // Puts a setting in place of `method: auto`; the record says which it is and why.
  void choose(MethodChoice choice, MethodRecord record);
  const std::optional<MethodRecord>& chosen() const { return chosen_; }

  // The drive of a sequence, with the way and on the ground that it has in its scene, which is loaded unless
  // loadScene() has done so; not of a recording.
  std::shared_ptr<const Trajectory> drive(std::size_t sequence) const;

  // The shots of a frame, one per sensor.
  std::vector<Shot> shots(std::size_t sequence, std::uint32_t frame) const;

  // One line each: what is computed and what is left out, and why.
  std::vector<std::string> modelled() const;

  // Throws InputError where the method draws no passes that could be kept, or `method: auto` may choose one that does
  // not.
  void requirePasses() const;
  // Throws InputError where the method may fire several rays a beam: kept hits are images with a pixel a beam.
  void requireOneRay() const;

  // The columns that the scans have besides their positions: those asked for, without an intensity that no effect sets.
  ColumnSet columns() const;

  // Upper bound of what a frame takes while it is made.
  std::uint64_t bytesPerFrameInMemory() const;
  // How many frames are made at a time: one for each thread, but no more than half of the memory holds.
  std::size_t framesInFlight() const;
  // What the program takes with scenes of so many bytes, as methods hold them, and the frames in flight.
  std::uint64_t bytesInMemory(std::uint64_t scenes) const;
  // Throws InputError where a scene of so many bytes, in the form that the method has made of it, and the frames in
  // flight take more memory than there is. `scene`: what messages call it.
  void checkMemory(std::uint64_t bytes, const std::string& scene) const;

 private:
  // Drives that follow from their scenes, by their sequences; found when the scenes are loaded.
  struct Drives {
    std::mutex mutex;
    std::map<std::size_t, std::shared_ptr<const Trajectory>> known;
  };
  void findDrives(const Sequence& sequence, const Scene& scene) const;

  // Of the sensors mounted so.
  VehicleHits traceOwnVehicle(const std::vector<Pose>& mounts) const;
  void readOwnVehicle();
  void addDrawnChannels();
  void checkDraws() const;
  std::string vehicleLine() const;
  Scene recordedScene(const Sequence& sequence) const;
  Shot recordedShot(const std::string& sample, std::uint32_t frame, std::size_t sensor) const;

  Pipeline pipeline_;
  std::optional<MethodRecord> chosen_;
  Channels channels_;  // what scans need
  Channels traced_;    // and recordings
  std::vector<std::shared_ptr<const BeamTable>> beams_;
  std::vector<std::shared_ptr<const Footprint>> footprints_;  // likewise; null: one ray a beam
  std::shared_ptr<const Scene> vehicle_;                      // null: no own vehicle
  FrameSettings settings_;
  std::unique_ptr<DrawnSettings> drawn_ = std::make_unique<DrawnSettings>();
  std::unique_ptr<Drives> drives_ = std::make_unique<Drives>();
};

}  // namespace scanmill
