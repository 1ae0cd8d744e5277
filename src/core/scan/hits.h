#pragma once

// The hit of each ray: exact and noise-free, misses included. This header is installed because
// methods/interface/method.h includes it.
//
//   std::size_t met = 0;
//   for (std::size_t ray = 0; ray < hits.rays(); ++ray) met += hits.hit(ray) ? 1 : 0;

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/vec.h"
#include "scan/channels.h"

namespace scanmill {

// The range of a ray that hits nothing between the sensor's minimum and maximum range.
constexpr float kMiss = std::numeric_limits<float>::infinity();

// Value of Hits::material for a surface without a material in Scene::materials. Such a surface is matt.
constexpr std::uint16_t kNoMaterial = 0xFFFF;

// How a ray reached its hit.
enum class RayPath : std::uint8_t {
  Direct,
  ThroughGlass,
  Mirrored,    // a mirror reflected the ray at least once
  EgoVehicle,  // the ray ends at the vehicle that carries the sensor
};

// A structure of arrays with one entry per ray. Most sensors fire one ray per beam; ray i then belongs to beam i, and
// each array is an image of rings x columns, indexed by ring * columns + column. An array is empty if its channel was
// not asked for. A ray that misses has the range kMiss and zero in all other arrays.
struct Hits {
  std::uint32_t rings = 0;    // number of the sensor's rings
  std::uint32_t columns = 0;  // number of the sensor's columns
  Channels channels;

  // If beams fire several rays: the beam of each ray, and the fraction of the beam's power that the ray carries. Both
  // arrays are empty if every beam fires one ray.
  std::vector<std::uint32_t> beamOfRay;
  std::vector<float> weightOfRay;
  std::vector<RayPath> pathOfRay;  // empty: all rays are direct
  bool glassIsClear = false;       // true: rays pass through panes, which reflect nothing diffusely

  std::vector<float> range;              // m, from the ray's origin along the ray
  std::vector<Vec3f> normal;             // unit normal of the triangle, world axes, turned towards the sensor
  std::vector<std::uint32_t> instance;   // id of the object instance; 0: none (stuff)
  std::vector<std::uint16_t> semantic;   // class id of the ontology; 0: unlabeled
  std::vector<std::uint16_t> material;   // index into Scene::materials
  std::vector<std::uint32_t> primitive;  // index of the triangle in its mesh
  std::vector<float> reflectance;        // near-infrared, 0 to 1, with the texture applied
  std::vector<float> incidence;          // cosine of the angle between the normal and the beam, 0 to 1

  // How the material reflects at the hit. A method fills these three arrays only if it has a value for each ray, for
  // example from images that another program rendered. If they are empty, the values of Scene::materials apply. Either
  // all three are filled or none.
  std::vector<float> roughness;         // 0 (mirror) to 1 (matt)
  std::vector<float> metallic;          // 0 to 1
  std::vector<float> retroreflectance;  // added reflectance towards the sensor; 1: as a white Lambertian target

  // The indices of rays that the method gave up, ascending. They are neither hits nor misses; their range is set to
  // kMiss.
  std::vector<std::uint32_t> unresolved;

  std::size_t size() const { return std::size_t{rings} * columns; }  // number of beams
  std::size_t rays() const { return range.size(); }
  bool hit(std::size_t ray) const { return range[ray] < kMiss; }

  // Gives `range` and the array of each channel in `asked` one undefined value per beam. Empties all other arrays.
  void reset(std::uint32_t ringCount, std::uint32_t columnCount, Channels asked);
};

// Calls visit(row, member) for each channel: its row of kChannels and the pointer to its member of Hits.
template <class Visit>
constexpr void forEachChannel(const Visit& visit) {
  visit(rowOf(Channel::Range), &Hits::range);
  visit(rowOf(Channel::Normal), &Hits::normal);
  visit(rowOf(Channel::Instance), &Hits::instance);
  visit(rowOf(Channel::Semantic), &Hits::semantic);
  visit(rowOf(Channel::Material), &Hits::material);
  visit(rowOf(Channel::Primitive), &Hits::primitive);
  visit(rowOf(Channel::Reflectance), &Hits::reflectance);
  visit(rowOf(Channel::Incidence), &Hits::incidence);
}
static_assert(
    [] {
      std::size_t next = 0;
      forEachChannel([&](const ChannelRow& row, auto) { next += next < kChannels.size() && &row == &kChannels[next]; });
      return next == kChannels.size();
    }(),
    "visit every channel, in the order of the rows");

inline void Hits::reset(std::uint32_t ringCount, std::uint32_t columnCount, Channels asked) {
  rings = ringCount;
  columns = columnCount;
  channels = asked | Channel::Range;
  beamOfRay.clear();
  weightOfRay.clear();
  pathOfRay.clear();
  glassIsClear = false;
  forEachChannel(
      [&](const ChannelRow& row, auto member) { (this->*member).resize(channels.has(row.channel) ? size() : 0); });
  roughness.clear();
  metallic.clear();
  retroreflectance.clear();
  unresolved.clear();
}

}  // namespace scanmill
