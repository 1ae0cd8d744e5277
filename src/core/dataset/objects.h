#pragma once

// The member `<key>.objects.json` of a sample: the object instances near its sensors, their boxes, and how much of each
// object a sensor sees. Its JSON Schema is docs/objects.schema.json. Lengths are in metres, times in seconds since the
// start of the sequence; frames are right-handed with x forward, y left, z up; quaternions are w, x, y, z.

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
// Returns the name of the member that lists the objects of the sample with this key.
std::string objectsMember(const std::string& key);

// How a sensor sees an object in one revolution.
struct ObjectView {
  std::string sensor;
  // Firing time (s) of the middle one of the beams that point at the object; if nothing in the scene moves during a
  // revolution, the time of the scan.
  double time = 0;
  Pose sensorFromBox;            // pose of the box at `time`, in the frame of the scan's points
  std::uint64_t points = 0;      // number of the scan's points on the object, after all effects
  std::uint32_t beams = 0;       // number of beams whose axis hits the object first, within the sensor's range
  std::uint32_t beamsAlone = 0;  // number of beams whose axis would hit the object if nothing occluded it
  double truncation = 0;         // fraction of the box, as seen from the sensor, outside the sensor's view or range
  std::optional<double> nearestRange{};  // m, least noise-free range of these beams; none if `beams` is 0

  // Returns `beams` / `beamsAlone`, limited to 1: the fraction of the beams at the object that are not occluded.
  // Returns nothing if both counts are 0.
  std::optional<double> visibility() const;
};

struct ObjectRecord {
  std::uint32_t id = 0;            // instance id, as in the column `instance`
  std::uint16_t semantic = 0;      // class id; points of the object may have the class for moving objects instead
  std::string name;                // name of the object in the scene
  std::vector<std::string> parts;  // names of the nodes that the object consists of
  bool moves = false;              // true if the object moves at any time of this sequence
  Pose worldFromBox;               // pose of the box's centre at the sample's time
  Vec3d size;                      // m: length along x, width along y, height along z
  bool headingKnown = true;        // false: x is along the box's longer side, and may point forward or backward
  Vec3d velocity;                  // m/s over ground, world axes
  std::vector<ObjectView> views;   // one for each sensor whose range reaches the box
};

struct SampleObjects {
  std::string key;
  double time = 0;  // s, time of the sample
  std::vector<ObjectRecord> objects;

  // Returns the number of objects of each class, by class id.
  std::map<std::uint16_t, ObjectCount> counts() const;
};

// Returns the text of a sample's member `<key>.objects.json`: lengths are rounded to 0.1 mm, speeds to 0.1 mm/s,
// fractions to 0.001. Throws Error for a class that the ontology lacks and for a value that is not finite.
std::string objectsJson(const SampleObjects& sample, const Ontology& ontology);

// Parses a text that objectsJson() has returned. Throws an InputError that begins with `name` and gives the place in
// the text and the problem.
SampleObjects parseObjects(std::string_view text, const std::string& name, const Ontology& ontology);

}  // namespace scanmill
