#pragma once

// Compares the hits of a method with exact hits (called the truth), beam by beam, over any number of shots.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evaluate/exact/exact.h"
#include "evaluate/spread.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// The errors of a group of beams. Each beam is counted once: beams = bothHit + bothMiss + falseNegatives +
// falsePositives + unresolved. For nearestTo and nearestFrom, the nearest point may belong to any beam, also to a beam
// of another group.
struct GroupErrors {
  std::uint64_t beams = 0, bothHit = 0, bothMiss = 0;
  std::uint64_t falseNegatives = 0;  // beams that hit only in the truth
  std::uint64_t falsePositives = 0;  // beams that hit only with the tested method
  std::uint64_t unresolved = 0;      // beams that the tested method could not trace
  std::uint64_t sameClass = 0;       // beams of bothHit whose two hits have the same class
  std::uint64_t sameInstance = 0;    // beams of bothHit whose two hits have the same instance
  std::uint64_t sameLabel = 0;       // beams of bothHit whose two hits have the same class and instance
  Spread range;                      // |tested - true range| of the beams in bothHit (m)
  Spread intensity;    // |tested - true intensity| of the beams in bothHit; empty if intensities are not compared
  Spread nearestTo;    // distances from the beams' true points to the nearest tested point (m)
  Spread nearestFrom;  // distances from the beams' tested points to the nearest true point (m)

  double missRate() const { return shareOf(falseNegatives + falsePositives + unresolved, beams); }
  double labels() const { return shareOf(sameLabel, bothHit, 1); }
  double classAgreed() const { return shareOf(sameClass, bothHit, 1); }
  double instanceAgreed() const { return shareOf(sameInstance, bothHit, 1); }
  // Returns the largest distance (m) in nearestTo and nearestFrom; 0 if there are no points.
  double hausdorff() const { return std::max(nearestTo.max, nearestFrom.max); }
};

struct ErrorGroup {
  std::string name;  // name of the group, such as "10 to 20 m", "60 to 75 deg", "edges" or "car"
  // The ends of the band, in metres or degrees. The upper end belongs to the next band, if there is one; it is infinite
  // for the last band of ranges. Both are 0 if the group is not a band.
  double low = 0;
  double high = 0;
  GroupErrors errors;
};

// How many object instances of one size range the tested method finds. Only instances that at least one beam hits in
// the truth are counted.
struct SizeRecall {
  std::string name;
  double low = 0, high = 0;          // ends of the size range (m); the upper end is excluded
  std::uint64_t instances = 0;       // number of instances of this size
  std::uint64_t instancesFound = 0;  // number of these instances that have beams counted in `beamsFound`
  std::uint64_t beams = 0;           // number of beams whose true hit is on an instance of this size
  std::uint64_t beamsFound = 0;      // number of beams counted in `beams` whose tested hit is on the same instance
};

// The errors of all beams, and of groups of beams. A beam is grouped by its true hit, otherwise by its tested hit.
struct BeamErrors {
  GroupErrors all;
  std::vector<ErrorGroup> byRange;  // bands of the range (m)
  // Bands of the angle between beam and true surface normal (degrees); only beams with a true hit.
  std::vector<ErrorGroup> byIncidence;
  std::vector<ErrorGroup> byEdge;       // two groups: "interior" and "edges"
  std::vector<ErrorGroup> byClass;      // one group per class that occurs, sorted by class id
  std::vector<SizeRecall> byThickness;  // object instances grouped by the shortest edge of their box
  std::vector<SizeRecall> byLength;     // object instances grouped by the longest edge of their box
};

// A shot with the exact hits of its beams, and data that are derived from these hits.
struct TrueShot {
  Shot shot;
  ExactHits truth;  // exact hits with at least the channels kErrorChannels
  // For each beam 1 if it is near an edge, see edgeBeams(); empty if no beam is near an edge.
  std::vector<std::uint8_t> edges;
  std::vector<float> intensity;  // the noise-free intensity of each beam; empty if intensities are not compared
};

inline constexpr Channels kErrorChannels =
    Channels(Channel::Range) | Channel::Instance | Channel::Semantic | Channel::Incidence;

// Accumulates the errors of shots.
class BeamErrorSum {
 public:
  // `scene`: provides the classes and the sizes of object instances. It must outlive this object.
  explicit BeamErrorSum(const Scene& scene);
  ~BeamErrorSum();

  // Adds a shot. `tested`: hits with the channels Range, Instance and Semantic; a range of NaN counts as a miss.
  // `intensity`: tested intensity of each beam; empty if not compared. `nearestTo`: distance (m) from each beam's true
  // point to the nearest tested point. `nearestFrom`: distance from each beam's tested point to the nearest true point.
  // Unknown distances are NaN. A list is empty or has an entry for each beam. Throws Error if `tested` or a list
  // has another number of beams than `truth`, or if the truth hits instances that the scene does not have.
  void add(const TrueShot& truth, const Hits& tested, std::span<const float> intensity,
           std::span<const float> nearestTo = {}, std::span<const float> nearestFrom = {});
  BeamErrors finish();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns the bounding boxes of the objects of each mesh of a scene, in the mesh's frame (m); the index of an object is
// Surface::object - 1.
std::vector<std::vector<Box>> objectBoxes(const Scene& scene);

// The shortest and longest edge (m) of an object instance's bounding box, which is aligned with its mesh's axes.
struct InstanceSize {
  double smallest = 0, largest = 0;
};
// Returns the sizes of a scene's object instances, indexed by instance id; 0 for the id 0 and ids that do not occur.
std::vector<InstanceSize> instanceSizes(const Scene& scene);

}  // namespace scanmill
