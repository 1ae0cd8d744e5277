#pragma once

// Compares the hits of a method with the truth, beam by beam, over any number of shots.

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

// The errors of a group of beams. Each beam counts once: beams = bothHit + bothMiss + falseNegatives + falsePositives +
// unresolved. The distances nearestTo and nearestFrom are to the nearest point of any beam, also of another group.
struct GroupErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t bothMiss = 0;
  std::uint64_t falseNegatives = 0;  // only the truth hits
  std::uint64_t falsePositives = 0;  // only the tested method hits
  std::uint64_t unresolved = 0;      // the tested method gave up
  std::uint64_t sameClass = 0;       // beams of bothHit with the same class
  std::uint64_t sameInstance = 0;    // beams of bothHit with the same instance
  std::uint64_t sameLabel = 0;       // beams of bothHit with the same class and instance
  Spread range;                      // |tested - truth| of the beams of bothHit (m)
  Spread intensity;    // |tested - truth| of the beams of bothHit, in the intensity's unit; empty without intensities
  Spread nearestTo;    // from the beams' true points to the nearest tested point (m)
  Spread nearestFrom;  // from the beams' tested points to the nearest true point (m)

  double missRate() const;        // (falseNegatives + falsePositives + unresolved) / beams; 0 without beams
  double labels() const;          // sameLabel / bothHit; 1 where bothHit is 0
  double classAgreed() const;     // sameClass / bothHit; 1 where bothHit is 0
  double instanceAgreed() const;  // sameInstance / bothHit; 1 where bothHit is 0
  double hausdorff() const;       // the largest distance of nearestTo and nearestFrom (m); 0 without points
};

struct ErrorGroup {
  std::string name;  // "10 to 20 m", "60 to 75 deg", "edges", "car"
  // The ends of a band, in metres or degrees; the upper end is excluded, and infinite if the band is open. Both are 0
  // if the group is not a band.
  double low = 0;
  double high = 0;
  GroupErrors errors;
};

// Recall of the things of one size range. A thing is an instance that at least one true beam hits.
struct SizeRecall {
  std::string name;
  double low = 0, high = 0;       // m, the size range; the upper end is excluded
  std::uint64_t things = 0;       // things of this size
  std::uint64_t thingsFound = 0;  // those of them that at least one beam of the tested method hits too
  std::uint64_t beams = 0;        // beams whose true hit is on a thing of this size
  std::uint64_t beamsFound = 0;   // those of them that hit the same instance by the tested method
};

// The errors of all beams, and of groups of beams. A beam belongs to the bands and to the class of its true hit, or of
// the tested hit if it has no true hit.
struct BeamErrors {
  GroupErrors all;
  std::vector<ErrorGroup> byRange;      // bands of range
  std::vector<ErrorGroup> byIncidence;  // bands of the angle between beam and true normal (degrees); true hits only
  std::vector<ErrorGroup> byPlace;      // "interior" and "edges"
  std::vector<ErrorGroup> byClass;      // the classes of the ontology that occur, by their ids
  std::vector<SizeRecall> byThickness;  // things by the smallest side of their box
  std::vector<SizeRecall> byLength;     // things by the largest side of their box
};

// A shot with the truth about each of its beams.
struct TrueShot {
  Shot shot;
  ExactHits truth;                  // with the channels of kErrorChannels
  std::vector<std::uint8_t> edges;  // 1 for beams near an edge, see edgeBeams(); empty if no beam is near one
  std::vector<float> intensity;     // the noise-free intensity of each beam; empty if it is not compared
};

inline constexpr Channels kErrorChannels =
    Channels(Channel::Range) | Channel::Instance | Channel::Semantic | Channel::Incidence;

// Adds up the errors of shots.
class BeamErrorSum {
 public:
  // The scene gives the classes and the sizes of things. It must outlive the sum.
  explicit BeamErrorSum(const Scene& scene);
  ~BeamErrorSum();
  BeamErrorSum(BeamErrorSum&&) noexcept;
  BeamErrorSum& operator=(BeamErrorSum&&) noexcept;

  // Adds a shot. `tested` has the channels Range, Instance and Semantic; a range that is not a number is a miss.
  // `intensity` holds the tested intensity of each beam, or nothing. `nearestTo` holds for each beam the distance (m)
  // from its true point to the nearest tested point, `nearestFrom` that from its tested point to the nearest true
  // point; an unknown distance is NaN, and either list may be empty. Throws Error if the sizes differ.
  void add(const TrueShot& truth, const Hits& tested, std::span<const float> intensity,
           std::span<const float> nearestTo = {}, std::span<const float> nearestFrom = {});
  BeamErrors finish() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// The sides (m) of a thing's box along the axes of its own mesh.
struct ThingSize {
  double smallest = 0;
  double largest = 0;
};
// Returns the sizes of a scene's things. The index is the instance id; id 0 and ids that do not occur have zeroes.
std::vector<ThingSize> thingSizes(const Scene& scene);

}  // namespace scanmill
