// Writes the annotations of nuScenes: the boxes of objects, and the objects that the boxes of a scene belong to.

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "exports/nuscenes_names.h"

namespace scanmill {

namespace {

constexpr double kMoving = 0.2;  // m/s, speed above which an object counts as moving

// Returns the token of one of nuScenes' four levels of visibility, "1" to "4". nuScenes has no level for an unknown
// visibility; such an object, which only edges of beams hit, gets the lowest one.
std::string visibilityToken(const std::optional<double>& visible) {
  const double share = visible.value_or(0);
  return share < 0.4 ? "1" : share < 0.6 ? "2" : share < 0.8 ? "3" : "4";
}

// Returns the attribute (moving, parked, ...) of an object; empty if nuScenes has no attribute for its category.
std::string attributeOf(const std::string& category, const ObjectRecord& object) {
  const bool moving = length(object.velocity) > kMoving;
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

  // Adds the rows, and returns the number of annotations.
  std::size_t add() {
    std::size_t annotations = 0;
    std::map<std::uint32_t, Track> tracks;  // by the dataset's instance ids
    forAnnotated([&](std::size_t f, const ObjectRecord& object, const Seen&, const SemanticClass& category) {
      Track& track = tracks[object.id];
      if (track.frames.empty()) track.category = category.id;
      track.frames.push_back(f);
      for (const auto side : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
        track.size.*side = std::max(track.size.*side, object.size.*side);
      }
    });
    forAnnotated([&](std::size_t f, const ObjectRecord& object, const Seen& seen, const SemanticClass& category) {
      rows_.add("sample_annotation", annotation(f, object, seen, tracks.at(object.id), category.name));
      ++annotations;
    });
    for (const auto& [id, track] : tracks) {
      rows_.add("instance", {{"token", instanceToken(id)},
                             {"category_token", rows_.token("category", std::to_string(track.category))},
                             {"nbr_annotations", track.frames.size()},
                             {"first_annotation_token", annotationToken(track.frames.front(), id)},
                             {"last_annotation_token", annotationToken(track.frames.back(), id)}});
    }
    return annotations;
  }

 private:
  // Sums up what the exported sensors see of an object.
  struct Seen {
    std::uint64_t points = 0;               // of all sensors
    std::optional<double> visibility;       // the greatest one
    const ObjectView* firstView = nullptr;  // by the first sensor with points on the object
    std::size_t sensor = 0;                 // index of the sensor of firstView
  };

  Seen seenBy(const ObjectRecord& object) const {
    Seen seen;
    for (std::size_t i = 0; i < plan_.sensors.size(); ++i) {
      for (const ObjectView& view : object.views) {
        if (view.sensor != plan_.sensors[i]->name || view.points == 0) continue;
        seen.points += view.points;
        seen.visibility = std::max(seen.visibility, view.visibility());
        if (seen.firstView != nullptr) continue;
        seen.firstView = &view;
        seen.sensor = i;
      }
    }
    return seen;
  }

  // An object of a sequence: nuScenes lists it once, and refers to it from each of its annotations.
  struct Track {
    std::uint16_t category = 0;
    // m, greatest sides of the object's boxes: nuScenes gives an instance one size, but an animated object's box
    // changes with its shape.
    Vec3d size;
    std::vector<std::size_t> frames;  // frames in which the object is annotated
  };

  // Calls work(frame, object, seen, category) for all objects of a sequence that are annotated, frame by frame.
  template <class Do>
  void forAnnotated(const Do& work) const {
    for (std::size_t f = 0; f < sequence_.samples.size(); ++f) {
      const std::optional<SampleObjects> all = read_(sequenceNumber_, f);
      if (!all) continue;
      for (const ObjectRecord& object : all->objects) {
        const SemanticClass& category = plan_.classes.classOf(object.semantic);
        const Seen seen = seenBy(object);
        if (category.thing && seen.points > 0) work(f, object, seen, category);
      }
    }
  }

  std::string annotationToken(std::size_t f, std::uint32_t id) const {
    const SampleRecord& sample = plan_.manifest.samples[sequence_.samples[f]];
    return rows_.token("sample_annotation", fmt::format("{} {}", sample.key, id));
  }

  std::string instanceToken(std::uint32_t id) const {
    return rows_.token("instance", fmt::format("{} {}", sequence_.name, id));
  }

  // Returns a row of sample_annotation. Its box is the object's box relative to the first sensor that sees it, when the
  // beams hit the object, placed in the world by the sensor's pose at the start of the revolution. The box thus fits
  // the points of this sensor.
  OrderedJson annotation(std::size_t f, const ObjectRecord& object, const Seen& seen, const Track& track,
                         const std::string& category) const {
    const SampleRecord& sample = plan_.manifest.samples[sequence_.samples[f]];
    const std::string what = fmt::format("{}: object {}", sample.key, object.id);
    const Pose worldFromBox =
        scanOf(plan_, sample, seen.sensor).worldFromSensor.front() * seen.firstView->sensorFromBox;
    const Vec3d& size = track.size;
    const auto current = std::ranges::lower_bound(track.frames, f);
    const auto tokenAt = [&](auto frame) { return annotationToken(*frame, object.id); };
    OrderedJson attributes = OrderedJson::array();
    if (const std::string name = attributeOf(category, object); !name.empty()) {
      attributes.push_back(rows_.token("attribute", name));
    }
    return {{"token", tokenAt(current)},
            {"sample_token", rows_.token("sample", sample.key)},
            {"instance_token", instanceToken(object.id)},
            {"visibility_token", visibilityToken(seen.visibility)},
            {"attribute_tokens", std::move(attributes)},
            {"translation", listOf(worldFromBox.translation, what)},
            {"size", listOf(Vec3d{size.y, size.x, size.z}, what)},
            {"rotation", listOf(worldFromBox.rotation, what)},
            {"prev", current == track.frames.begin() ? "" : tokenAt(current - 1)},
            {"next", current + 1 == track.frames.end() ? "" : tokenAt(current + 1)},
            {"num_lidar_pts", seen.points},
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
