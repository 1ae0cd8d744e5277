#pragma once

// What a method's hits cost against the truth, beam by beam, over any number of shots.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evaluate/spread.h"
#include "methods/exact/exact.h"
#include "scan/hits.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// Of a group of beams. beams = bothHit + bothMiss + lost + spurious + unresolved.
struct GroupErrors {
  std::uint64_t beams = 0;
  std::uint64_t bothHit = 0;
  std::uint64_t bothMiss = 0;
  std::uint64_t lost = 0;          // only the truth hits
  std::uint64_t spurious = 0;      // only the tested method hits
  std::uint64_t unresolved = 0;    // the tested method gave up
  std::uint64_t sameClass = 0;     // of bothHit
  std::uint64_t sameInstance = 0;  // of bothHit
  std::uint64_t sameLabel = 0;     // of bothHit: class and instance
  Spread range;                    // |tested - truth| of bothHit (m)
  Spread intensity;                // |tested - truth| of bothHit, in the intensity's unit; none where it is not given
  Spread nearestTo;                // from the beams' true points to the nearest tested one, of whatever group (m)
  Spread nearestFrom;              // from the beams' tested points to the nearest true one, of whatever group (m)

  double missRate() const;        // (lost + spurious + unresolved) / beams; 0 of no beams
  double labels() const;          // sameLabel / bothHit; 1 of none
  double classAgreed() const;     // sameClass / bothHit; 1 of none
  double instanceAgreed() const;  // sameInstance / bothHit; 1 of none
  double hausdorff() const;       // the largest of nearestTo and nearestFrom (m); 0 of none
};

struct ErrorGroup {
  std::string name;  // "10 to 20 m", "60 to 75 deg", "edges", "car"
  double low = 0;    // of a band: m or degrees, its upper end excluded; 0 where it is no band
  double high = 0;   // infinite where it is open
  GroupErrors errors;
};

// How much of the things of one size is found. A thing is an instance that at least one true beam meets.
struct SizeRecall {
  std::string name;
  double low = 0, high = 0;  // m
  std::uint64_t things = 0;
  std::uint64_t thingsFound = 0;  // at least one beam meets the same instance
  std::uint64_t beams = 0;        // that meet such a thing in truth
  std::uint64_t beamsFound = 0;   // and the same instance by the tested method
};

// A beam belongs to the bands and the class of its true hit, or of the tested one where in truth there is none.
struct BeamErrors {
  GroupErrors all;
  std::vector<ErrorGroup> byRange;      // bands of range
  std::vector<ErrorGroup> byIncidence;  // bands of the angle between beam and true normal (degrees); true hits only
  std::vector<ErrorGroup> byPlace;      // "interior" and "edges"
  std::vector<ErrorGroup> byClass;      // of the ontology, those that occur, by id
  std::vector<SizeRecall> byThickness;  // things by the smallest side of their box
  std::vector<SizeRecall> byLength;     // things by the largest side of their box
};

// What the truth is of one shot.
struct TrueShot {
  Shot shot;
  ExactHits truth;                  // with the channels of kErrorChannels
  std::vector<std::uint8_t> edges;  // 1 where a beam lies near an edge (edgeBeams()); empty: none does
  std::vector<float> intensity;     // noise-free, per beam; empty: not compared
};

inline constexpr Channels kErrorChannels =
    Channels(Channel::Range) | Channel::Instance | Channel::Semantic | Channel::Incidence;

class BeamErrorSum {
 public:
  // The scene gives the classes and the sizes of things; it must outlive the sum.
  explicit BeamErrorSum(const Scene& scene);
  ~BeamErrorSum();
  BeamErrorSum(BeamErrorSum&&) noexcept;
  BeamErrorSum& operator=(BeamErrorSum&&) noexcept;

  // `tested`: channels Range, Instance, Semantic. `intensity` as TrueShot::intensity, or empty. Throws Error where the
  // sizes differ. Neither counts: a NaN range is a miss. `nearestTo` and `nearestFrom`, per beam or empty: how far its
  // true point lies from the nearest tested one, and its tested point from the nearest true one (m); NaN: unknown.
  void add(const TrueShot& truth, const Hits& tested, std::span<const float> intensity,
           std::span<const float> nearestTo = {}, std::span<const float> nearestFrom = {});
  BeamErrors finish() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Smallest and largest side (m) of the box, along the mesh's own axes, of the thing with each instance id (index: id);
// zeroes for id 0 and for things that do not occur.
struct ThingSize {
  double smallest = 0;
  double largest = 0;
};
std::vector<ThingSize> thingSizes(const Scene& scene);

}  // namespace scanmill
