#pragma once

// The member `<key>.objects.json` of a sample: the object instances near its sensors, their boxes, and how much of each
// a sensor sees. Its JSON Schema is docs/objects.schema.json. Lengths are in metres, times in seconds since the start
// of the sequence; frames are right-handed with x forward, y left, z up; quaternions are w, x, y, z.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "dataset/manifest.h"
#include "scene/ontology.h"

namespace scanmill {

inline constexpr std::string_view kObjectsSuffix = "objects.json";
// Returns the member's name.
std::string objectsMember(const std::string& key);

// How a sensor sees an object in one revolution.
struct ObjectView {
  std::string sensor;
  // When the middle one of the beams that point at the object fires; the scan's own time if nothing moves during a
  // revolution.
  double time = 0;
  Pose sensorFromBox;            // pose of the box at `time`, in the frame of the scan's points
  std::uint64_t points = 0;      // points of the scan on the object, after all effects
  std::uint32_t beams = 0;       // beams whose axis hits the object first, within the sensor's range
  std::uint32_t beamsAlone = 0;  // beams whose axis would hit the object if nothing occluded it
  double truncation = 0;         // share of the box, as seen from the sensor, outside its field of view or range
  std::optional<double> nearestRange{};  // m, noise-free, least range of `beams`; none: there are no such beams

  // Returns the share of beams that nothing occludes, 0 to 1; none if no beam would hit the object.
  std::optional<double> visibility() const;
};

struct ObjectRecord {
  std::uint32_t id = 0;            // as in the column `instance`
  std::uint16_t semantic = 0;      // class id; points of a moving object may have the class for moving ones
  std::string name;                // in the scene
  std::vector<std::string> parts;  // names of the nodes that the object consists of
  bool moves = false;              // in this sequence, at any time
  Pose worldFromBox;               // pose of the box's centre at the sample's time
  Vec3d size;                      // m: length along x, width along y, height along z
  bool headingKnown = true;        // false: x is along the box's longer side, and may point forward or backward
  Vec3d velocity;                  // m/s over ground, world axes
  std::vector<ObjectView> views;   // by the sensors whose range reaches the box
};

struct SampleObjects {
  std::string key;
  double time = 0;  // s, when the sample's first scan begins
  std::vector<ObjectRecord> objects;

  // Returns the number of objects of each class.
  std::map<std::uint16_t, ObjectCount> counts() const;
};

// Returns the member's text: lengths are rounded to 0.1 mm, speeds to 0.1 mm/s, shares to 0.001. Throws Error for a
// class that the ontology lacks and for a value that is not finite.
std::string objectsJson(const SampleObjects& sample, const Ontology& ontology);

// Throws an InputError that begins with `name` and says at which place of the text what is wrong.
SampleObjects parseObjects(std::string_view text, const std::string& name, const Ontology& ontology);

}  // namespace scanmill
