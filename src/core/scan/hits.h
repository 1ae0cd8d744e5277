#pragma once

// What each ray meets: exact and noise-free, misses included.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/vec.h"
#include "scan/channels.h"

namespace scanmill {

// Range of a ray that met nothing between the sensor's minimum and maximum range.
constexpr float kMiss = std::numeric_limits<float>::infinity();

// A structure of arrays with one entry per ray. Most often a beam fires one ray: then ray i is that of beam i, and the
// arrays are images of rings x columns, beam index = ring * columns + column. A column that was not asked for is empty.
// On a miss: range kMiss, everything else zero.
struct Hits {
  std::uint32_t rings = 0;    // of the sensor
  std::uint32_t columns = 0;  // of the sensor
  Channels channels;

  // The beam of each ray, and its share of the beam's power, where beams fire several rays; both empty where every beam
  // fires one.
  std::vector<std::uint32_t> beamOfRay;
  std::vector<float> weightOfRay;

  std::vector<float> range;              // m, from the ray's own origin along the ray
  std::vector<Vec3f> normal;             // unit, world axes, of the triangle, turned towards the sensor
  std::vector<std::uint32_t> instance;   // 0: none (stuff)
  std::vector<std::uint16_t> semantic;   // class id of the ontology; 0: unlabeled
  std::vector<std::uint16_t> material;   // index into Scene::materials
  std::vector<std::uint32_t> primitive;  // triangle index in its mesh
  std::vector<float> reflectance;        // near-infrared, 0 to 1, texture applied
  std::vector<float> incidence;          // cosine of the angle between the normal and the beam, 0 to 1

  // How the material looks at the hit: filled by methods that know it per beam (passes drawn by others); empty where
  // the material's own figures hold. All three or none.
  std::vector<float> roughness;         // 0 mirror to 1 matt
  std::vector<float> metallic;          // 0 to 1
  std::vector<float> retroreflectance;  // in units of a white Lambertian target

  // Rays that the method gave up, ascending: neither hit nor miss. Their range is kMiss, as nothing is known of it.
  std::vector<std::uint32_t> unresolved;

  std::size_t size() const { return std::size_t{rings} * columns; }  // beams
  std::size_t rays() const { return range.size(); }
  bool hit(std::size_t ray) const { return range[ray] < kMiss; }

  // One ray a beam: sizes the columns that `asked` names (Range always) and empties the others, the surface parameters
  // and `unresolved` too; contents are undefined.
  void reset(std::uint32_t ringCount, std::uint32_t columnCount, Channels asked);
};

}  // namespace scanmill
