// Writes the annotations of nuScenes: the boxes of objects, and the objects that the boxes of a scene belong to.

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "exports/nuscenes_rows.h"

namespace scanmill {

namespace {

constexpr double kLeastMovingSpeed = 0.2;  // m/s, chosen by eye: slower objects count as standing

// Returns the token of one of nuScenes' four levels of visibility, "1" to "4". nuScenes has no level for an unknown
// visibility: an object that only edges of beams hit gets the lowest level.
std::string visibilityToken(const std::optional<double>& visibility) {
  const double fraction = visibility.value_or(0);
  return fraction < 0.4 ? "1" : fraction < 0.6 ? "2" : fraction < 0.8 ? "3" : "4";  // the levels of schema_nuscenes.md
}

// Returns the attribute (moving, parked, ...) of an object; empty if nuScenes has no attribute for its category.
std::string attributeOf(const std::string& category, const ObjectRecord& object) {
  const bool moving = length(object.velocity) > kLeastMovingSpeed;
  if (category == "vehicle.bicycle" || category == "vehicle.motorcycle") {
    return moving || object.moves ? "cycle.with_rider" : "cycle.without_rider";
  }
  if (category.starts_with("vehicle.")) {
    return moving ? "vehicle.moving" : object.moves ? "vehicle.stopped" : "vehicle.parked";
  }
  if (category.starts_with("human.")) return moving ? "pedestrian.moving" : "pedestrian.standing";
  return "";
}

// The annotations of one sequence.
class Annotations {
 public:
  Annotations(const ExportPlan& plan, const ReadObjects& read, std::size_t sequence, NuScenesRows& rows)
      : plan_(plan), read_(read), sequenceNumber_(sequence), sequence_(plan.sequences[sequence]), rows_(rows) {}

  // Adds the rows, and returns the number of annotations. Reads the objects twice, because the rows of a frame refer to
  // later frames.
  std::size_t add() {
    std::size_t annotations = 0;
    std::map<std::uint32_t, Track> tracks;  // tracks by the dataset's instance ids
    forAnnotated([&](std::size_t frame, const ObjectRecord& object, const Sighting&, const SemanticClass& category) {
      Track& track = tracks[object.id];
      if (track.frames.empty()) track.category = category.id;
      track.frames.push_back(frame);
      for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
        track.size.*axis = std::max(track.size.*axis, object.size.*axis);
      }
    });
    forAnnotated(
        [&](std::size_t frame, const ObjectRecord& object, const Sighting& sighting, const SemanticClass& category) {
          rows_.add("sample_annotation", annotation(frame, object, sighting, tracks.at(object.id), category.name));
          ++annotations;
        });
    for (const auto& [id, track] : tracks) {
      rows_.add("instance", {{"token", instanceToken(id)},
                             {"category_token", nuScenesToken(plan_, "category", std::to_string(track.category))},
                             {"nbr_annotations", track.frames.size()},
                             {"first_annotation_token", annotationToken(track.frames.front(), id)},
                             {"last_annotation_token", annotationToken(track.frames.back(), id)}});
    }
    return annotations;
  }

 private:
  // Sums up what the exported sensors see of an object in a frame.
  struct Sighting {
    std::uint64_t points = 0;               // sum over all sensors
    std::optional<double> visibility;       // highest among the sensors with points
    const ObjectView* firstView = nullptr;  // view of the first sensor with points on the object; null: none
    std::size_t sensor = 0;                 // index of the sensor of firstView
  };

  Sighting sightingOf(const ObjectRecord& object) const {
    Sighting sighting;
    for (std::size_t i = 0; i < plan_.sensors.size(); ++i) {
      for (const ObjectView& view : object.views) {
        if (view.sensor != plan_.sensors[i]->name || view.points == 0) continue;
        sighting.points += view.points;
        sighting.visibility = std::max(sighting.visibility, view.visibility());
        if (sighting.firstView != nullptr) continue;
        sighting.firstView = &view;
        sighting.sensor = i;
      }
    }
    return sighting;
  }

  // An object of a sequence: nuScenes lists it once, and refers to it from each of its annotations.
  struct Track {
    std::uint16_t category = 0;
    // m, greatest sides of the object's boxes: nuScenes gives an instance one size, but an animated object's box
    // changes with its shape.
    Vec3d size;
    std::vector<std::size_t> frames;  // frames in which the object is annotated
  };

  // Calls work(frame, object, sighting, category) for all objects of the sequence that are annotated, frame by frame.
  template <class Work>
  void forAnnotated(const Work& work) const {
    for (std::size_t frame = 0; frame < sequence_.samples.size(); ++frame) {
      const std::optional<SampleObjects> sample = read_(sequenceNumber_, frame);
      if (!sample) continue;
      for (const ObjectRecord& object : sample->objects) {
        const SemanticClass& category = plan_.classes.classOf(object.semantic);
        const Sighting sighting = sightingOf(object);
        if (category.thing && sighting.points > 0) work(frame, object, sighting, category);
      }
    }
  }

  std::string annotationToken(std::size_t frame, std::uint32_t id) const {
    const SampleRecord& sample = plan_.manifest.samples[sequence_.samples[frame]];
    return nuScenesToken(plan_, "sample_annotation", fmt::format("{} {}", sample.key, id));
  }

  std::string instanceToken(std::uint32_t id) const {
    return nuScenesToken(plan_, "instance", fmt::format("{} {}", sequence_.name, id));
  }

  // Returns a row of sample_annotation. The box has the pose relative to the first sensor with points on the object, at
  // the time when beams of this sensor hit the object. The sensor's pose at the start of the revolution transforms the
  // box to the world, so that the box fits the points of this sensor.
  OrderedJson annotation(std::size_t frame, const ObjectRecord& object, const Sighting& sighting, const Track& track,
                         const std::string& category) const {
    const SampleRecord& sample = plan_.manifest.samples[sequence_.samples[frame]];
    const std::string what = fmt::format("{}: object {}", sample.key, object.id);
    const Pose worldFromBox =
        scanOf(plan_, sample, sighting.sensor).worldFromSensor.front() * sighting.firstView->sensorFromBox;
    const Vec3d& size = track.size;
    const auto current = std::ranges::lower_bound(track.frames, frame);  // an iterator; frames are in order
    const auto tokenAt = [&](auto frameIterator) { return annotationToken(*frameIterator, object.id); };
    OrderedJson attributes = OrderedJson::array();
    if (const std::string name = attributeOf(category, object); !name.empty()) {
      attributes.push_back(nuScenesToken(plan_, "attribute", name));
    }
    return {{"token", tokenAt(current)},
            {"sample_token", nuScenesToken(plan_, "sample", sample.key)},
            {"instance_token", instanceToken(object.id)},
            {"visibility_token", visibilityToken(sighting.visibility)},
            {"attribute_tokens", std::move(attributes)},
            {"translation", listOf(worldFromBox.translation, what)},
            {"size", listOf(Vec3d{size.y, size.x, size.z}, what)},
            {"rotation", listOf(worldFromBox.rotation, what)},
            {"prev", current == track.frames.begin() ? "" : tokenAt(current - 1)},
            {"next", current + 1 == track.frames.end() ? "" : tokenAt(current + 1)},
            {"num_lidar_pts", sighting.points},
            {"num_radar_pts", 0}};
  }

  const ExportPlan& plan_;
  const ReadObjects& read_;
  std::size_t sequenceNumber_;
  const ExportSequence& sequence_;
  NuScenesRows& rows_;
};

}  // namespace

std::size_t addAnnotations(const ExportPlan& plan, const ReadObjects& read, std::size_t sequence, NuScenesRows& rows) {
  return Annotations(plan, read, sequence, rows).add();
}

}  // namespace scanmill
