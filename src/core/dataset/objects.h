#pragma once

// The member `<key>.objects.json` of a sample: the things near its sensors, their boxes, and how much of each a sensor
// sees. Its JSON Schema is docs/objects.schema.json. Lengths are metres, times seconds since the start of the sequence;
// frames are right-handed with x forward, y left, z up; quaternions w, x, y, z.

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
// The member's name.
std::string objectsMember(const std::string& key);

// What a sensor sees of an object in one revolution.
struct ObjectView {
  std::string sensor;
  // When the middle one of the beams that point at it fires; the scan's own time where nothing moves during one.
  double time = 0;
  Pose sensorFromBox;                    // of the box at that time, in the frame of the scan's points
  std::uint64_t points = 0;              // of the scan, with all its effects
  std::uint32_t beams = 0;               // whose axes meet it before anything else, within the sensor's range
  std::uint32_t beamsAlone = 0;          // whose axes would if nothing else were there
  double truncation = 0;                 // share of the box, as seen from the sensor, outside its field or its range
  std::optional<double> nearestRange{};  // m, noise-free, of the nearest of these beams; none where there is none

  // The share of the beams that nothing blocks, 0 to 1; none where no beam would meet the object.
  std::optional<double> visibility() const;
};

struct ObjectRecord {
  std::uint32_t id = 0;            // as in the column `instance`
  std::uint16_t semantic = 0;      // class id; points on what moves may have the class for that
  std::string name;                // in the scene
  std::vector<std::string> parts;  // names of the nodes that it is made of
  bool moves = false;              // in this sequence, at any time
  Pose worldFromBox;               // of the box's middle, at the sample's time
  Vec3d size;                      // m: length along x, width along y, height along z
  bool headingKnown = true;        // else the box's x is its longer side, and front and back are not told apart
  Vec3d velocity;                  // m/s over ground, world axes
  std::vector<ObjectView> views;   // of the sensors whose range reaches the box
};

struct SampleObjects {
  std::string key;
  double time = 0;  // of the sample's first scan
  std::vector<ObjectRecord> objects;

  // By class.
  std::map<std::uint16_t, ObjectCount> counts() const;
};

// The member's text: lengths are rounded to 0.1 mm, speeds to 0.1 mm/s, shares to 0.001. Throws Error for a class that
// the ontology lacks and for what is not finite.
std::string objectsJson(const SampleObjects& sample, const Ontology& ontology);

// Throws an InputError that begins with `name`, and names the place in it and what is wrong there.
SampleObjects parseObjects(std::string_view text, const std::string& name, const Ontology& ontology);

}  // namespace scanmill
