#pragma once

// Guesses what an asset shows (its concepts), its up axis and its unit, from names and shape.

#include <array>
#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "assets/asset.h"
#include "scenefile/concepts.h"

namespace scanmill::draft {

// Finds the concepts that names of nodes, materials, textures and files state.
class Vocabulary {
 public:
  explicit Vocabulary(const std::vector<Concept>& concepts) : concepts_(concepts) {}
  explicit Vocabulary(std::vector<Concept>&&) = delete;  // the concepts must outlive the vocabulary

  // Finds words, such as a project's name, that most names contain although the names state several kinds of objects.
  // Later calls ignore these words. `names`: all nodes, all materials, all textures or all files.
  void ignoreShared(const std::vector<std::string>& names);
  // Calls ignoreShared() for the nodes, the materials and the textures of an asset.
  void ignoreShared(const Asset& asset);

  // Returns the concept of a name; see scenefile/concepts.h. Ignored words count only in names without other words.
  const Concept* conceptOf(std::string_view name) const;
  // Like conceptOf(), but returns the concepts of all words; see conceptsIn() in scenefile/concepts.h.
  std::vector<const Concept*> conceptsIn(std::string_view name) const;
  const std::vector<Concept>& concepts() const { return concepts_; }

 private:
  // Returns the folded name without ignored words or, if it has no other words, the complete folded name.
  std::string tellingPart(std::string_view name) const;

  const std::vector<Concept>& concepts_;
  std::set<std::string> ignored_;  // words, as foldedName() returns them
};

// A part of an asset, and how many copies of it the asset contains.
struct CountedPart {
  const AssetPart* part;
  std::size_t copies;
};

// Returns Asset::parts, then the parts of Asset::instanced.
std::vector<CountedPart> partsOf(const Asset& asset);

// Returns the concept of each part, in the order of partsOf(); null for a part if no name contains a known word.
// `file`: the concept that the name of the file, or of its folder, states; null: none. The whole of a part is the one
// that its node's name states, otherwise `file` if this is a whole. The part's concept is the detail of the whole that
// the name of its material, texture or node (tried in this order) states, otherwise the whole itself: the material
// "glass" in a file "car" gives the glass of a car. Without a whole, the concept is what the material, the texture or
// the node states, otherwise `file`.
std::vector<const Concept*> guessParts(const Vocabulary& words, const Asset& asset, const Concept* file);

// Returns the name of the file's folder or, if that name only says what kind of files the folder contains, such as
// "meshes", the name of the folder above.
std::string folderName(const std::filesystem::path& file);

// The concept that the name of a file or of its folder states.
struct FileConcept {
  const Concept* shown = nullptr;  // null: none
  bool byFolder = false;           // true: the name of the folder states `shown`
};

// Returns the concept that the file's name states or, if that name states none, the concept that folderName() states.
// Returns none if the file itself states classes, as labelled point clouds do, or if it contains a place: the names of
// its parts state other objects, such as a house, trees, a car and a lawn in "house.obj". The folder of such a file may
// be named after the place.
FileConcept conceptOfFile(const Vocabulary& words, const Asset& asset);

// An object by whose size a unit is guessed.
struct SizedObject {
  const Concept* shown = nullptr;  // what the object is; null: unknown
  double longest = 0;              // longest edge of its bounding box (file's units)
};

struct FrameGuess {
  char up = 'z';
  std::string whyUp;  // the reason for `up` in words; empty if the file or its format states the axis
  bool doubtfulUp = false;
  bool statedUnit = false;  // true: the file or its format states the unit, which is not guessed
  double unit = 1;          // length of the file's unit (m)
  std::string whyUnit;
  bool doubtfulUnit = false;
  SizedObject object;              // the asset with its main concept, or an object of the place that the asset contains
  std::array<double, 3> extent{};  // size along x, y and z as the file was read, in the file's units
  bool severalObjects = false;     // true: the asset contains a place with several objects, such as a room
  char readUp = 'z';               // up axis that was assumed when the file was read
};

// Guesses the up axis of an asset that was read with the unit 1 and without a given axis, and measures what
// guessUnitsTogether() needs to guess the unit. `partConcepts`: see guessParts().
FrameGuess guessFrame(const Asset& asset, const std::vector<const Concept*>& partConcepts);

// Guesses the units of files that have the same format and folder, such that the objects have usual sizes. If one unit
// suits most of the files, they share it. Otherwise one unit is guessed for the tiles, which are files with about the
// same footprint, and one for the remaining files. Files that no shared unit suits get a unit of their own. A file with
// a doubtful up axis gets the axis of most other files. A unit that a file or its format states is kept, and marked as
// doubtful if it gives an unusual size.
void guessUnitsTogether(const std::vector<FrameGuess*>& files);

// Returns the ground in the file's name if the name also states an object, such as "grass-trees"; otherwise null.
const Concept* groundIn(const Vocabulary& words, const std::filesystem::path& file);

}  // namespace scanmill::draft
