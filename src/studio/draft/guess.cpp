#include "draft/guess.h"

#include <fmt/format.h>

#include "assets/meshes/asset_parts.h"
#include "base/text_scan.h"
#include "config/text.h"

namespace scanmill::draft {
namespace {

// Returns the detail of `whole` that has the same words as `detail`; for instance, the wheels of a train instead of the
// wheels of a car. Null if there is no such detail, if `detail` is no detail, or if an argument is null.
const Concept* detailOf(const std::vector<Concept>& concepts, const Concept* detail, const Concept* whole) {
  if (detail == nullptr || whole == nullptr || detail->kind != ConceptKind::Detail) return nullptr;
  const auto found = std::ranges::find_if(concepts, [&](const Concept& c) {
    return c.kind == ConceptKind::Detail && c.words == detail->words &&
           std::ranges::find(c.wholes, whole->name) != c.wholes.end();
  });
  return found == concepts.end() ? nullptr : &*found;
}

// Returns the concept with the most triangles; null if most triangles have no concept. If this concept is a detail,
// such as wheels, and the asset also has wholes, such as a car, returns the whole with the most triangles.
// `partConcepts`: see guessParts(); only Asset::parts count, not instances.
const Concept* mainConcept(const Asset& asset, const std::vector<const Concept*>& partConcepts) {
  std::map<const Concept*, std::size_t> triangles, trianglesOfWholes;
  for (std::size_t i = 0; i < asset.parts.size(); ++i) {
    const Concept* const shown = partConcepts[i];
    triangles[shown] += asset.parts[i].triangles.size();
    if (shown != nullptr && shown->kind == ConceptKind::Whole) {
      trianglesOfWholes[shown] += asset.parts[i].triangles.size();
    }
  }
  if (triangles.empty()) return nullptr;
  const auto mostFrequent = [](const std::map<const Concept*, std::size_t>& counts) {
    return std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
  };
  const Concept* const main = mostFrequent(triangles);
  const bool isDetail = main != nullptr && main->kind == ConceptKind::Detail;
  return isDetail && !trianglesOfWholes.empty() ? mostFrequent(trianglesOfWholes) : main;
}

// True if the names of the parts (and, if `fileConcept` is not null, the name of the file) state at least three
// different objects and grounds. The file then contains a place, such as a room, and not one object. Parts that may
// have the class of the file's concept, such as walls and doors of a house, do not count.
bool isPlace(const std::vector<const Concept*>& partConcepts, const Concept* fileConcept = nullptr) {
  constexpr std::size_t kSeveral = 3;
  std::set<const Concept*> stated;
  if (fileConcept != nullptr) stated.insert(fileConcept);
  for (const Concept* c : partConcepts) {
    if (c == nullptr || (c->kind != ConceptKind::Whole && c->kind != ConceptKind::Ground)) continue;
    const bool belongsToFile = fileConcept != nullptr && !fileConcept->classes.empty() &&
                               std::ranges::find(c->classes, fileConcept->classes.front()) != c->classes.end();
    if (!belongsToFile) stated.insert(c);
  }
  return stated.size() >= kSeveral;
}

// True if the file itself states classes, as labelled point clouds do. A single class without a known word does not
// count, since programs write one number for all points that nobody classified.
bool statesClasses(const Vocabulary& words, const Asset& asset) {
  std::set<std::string> classes;
  for (const AssetPart& part : asset.parts) classes.insert(part.ownClass);
  classes.erase("");
  return classes.size() > 1 || (!classes.empty() && words.conceptOf(*classes.begin()) != nullptr);
}

// Returns a folded name without the words in `ignored`.
std::string withoutWords(const std::string& folded, const std::set<std::string>& ignored) {
  std::string shorter;
  for (const std::string_view word : wordsOf(folded)) {
    if (!ignored.contains(std::string(word))) shorter += fmt::format("{}{}", shorter.empty() ? "" : " ", word);
  }
  return shorter;
}

std::string textureStem(const AssetPart& part) {
  return std::filesystem::path(textureName(part.texture)).stem().string();
}

bool isTall(const Concept& c) {
  static constexpr std::array<std::string_view, 8> kTall{
      "tree", "trunk", "pole", "street lamp", "traffic sign", "traffic light", "person", "transmission tower"};
  return std::ranges::find(kTall, c.name) != kTall.end();
}

bool isFlat(const Concept& c) {
  static constexpr std::array<std::string_view, 4> kLow{"car", "truck", "bus", "other vehicle"};
  return c.kind == ConceptKind::Ground || std::ranges::find(kLow, c.name) != kLow.end();
}

// Returns a score for y (`axis` 1) or z (2) as the up axis; the higher score wins. Objects usually start at 0 along the
// up axis and are centred along the other axes. Trees are tall; cars, grounds and places are low. The shape counts more
// than the origin; the scores and fractions were tuned on files of many programs. `low`: lower corner of the box.
double upScoreOf(const std::array<double, 3>& low, std::size_t axis, const FrameGuess& guess) {
  constexpr double kAtZero = 0.03, kThin = 0.1;  // kAtZero: fraction of the up extent; kThin: of the longest extent
  constexpr double kCentred = 0.1;               // fraction of the horizontal extent
  constexpr double kStartsAtZeroScore = 1, kCentredScore = 0.5, kShapeScore = 2;
  double score = 0;
  const std::array<double, 3>& extent = guess.extent;
  const double longest = *std::ranges::max_element(extent);
  if (longest <= 0) return 0;
  if (std::abs(low[axis]) <= kAtZero * std::max(extent[axis], kThin * longest)) score += kStartsAtZeroScore;
  const std::size_t horizontal = axis == 1 ? 2 : 1;  // z or y, if `axis` is up
  const double middle = low[horizontal] + extent[horizontal] / 2;
  if (std::abs(middle) <= kCentred * extent[horizontal]) score += kCentredScore;
  if (guess.severalObjects && extent[axis] < extent[horizontal]) score += kShapeScore;
  const Concept* const shown = guess.object.shown;
  if (shown == nullptr) return score;
  if (isTall(*shown) && extent[axis] > extent[horizontal]) score += kShapeScore;
  if (isFlat(*shown) && extent[axis] < extent[horizontal]) score += kShapeScore;
  return score;
}

// Lengths (m) of common units other than the metre.
constexpr std::array<double, 8> kUnits{0.01, 0.0254, 0.3048, 0.001, 0.1, 10.0, 100.0, 1000.0};
// Factor by which a size may be outside of its usual range if other files suggest the unit.
constexpr double kTolerance = 3;

std::string nameOf(const SizedObject& object) {
  return object.shown == nullptr ? "it" : "a " + object.shown->name;
}

// True if the object has a size and its concept has a usual size. Functions below that compare sizes require both.
bool hasUsualSize(const SizedObject& object) {
  return object.shown != nullptr && object.shown->size && object.longest > 0;
}

// True if the object's size with this unit (m) is in the usual range, extended by the factor `tolerance` at both ends.
bool fits(const SizedObject& object, double unit, double tolerance = 1) {
  const Range& usual = *object.shown->size;
  return Range{usual.low / tolerance, usual.high * tolerance}.contains(object.longest * unit);
}

std::string sizeWith(const SizedObject& object, double unit) {
  return fmt::format("{} of {:.3g} units is {:.3g} m with this unit, and {:g} to {:g} m are usual", nameOf(object),
                     object.longest, object.longest * unit, object.shown->size->low, object.shown->size->high);
}

// Sets the unit of a file: metres if its object then has a usual size, otherwise the common unit that gives a size
// nearest to the middle of the usual range. If no unit gives a usual size, keeps metres and marks the unit as doubtful.
void guessUnit(FrameGuess& guess) {
  const SizedObject& object = guess.object;
  if (fits(object, 1)) return;
  const Range& usual = *object.shown->size;
  const double usualMiddle = std::sqrt(usual.low * usual.high);
  double leastDeviation = 1e9;  // natural logarithm of the ratio of the size to usualMiddle
  for (const double unit : kUnits) {
    const double deviation = std::abs(std::log(object.longest * unit / usualMiddle));
    if (!fits(object, unit) || deviation >= leastDeviation) continue;
    leastDeviation = deviation;
    guess.unit = unit;
    guess.whyUnit = sizeWith(object, unit);
  }
  if (guess.unit != 1) return;
  guess.doubtfulUnit = true;
  guess.whyUnit = fmt::format("{} of {:.3g} m is unusual, but no common unit gives {:g} to {:g} m", nameOf(object),
                              object.longest, usual.low, usual.high);
}

// Sets the up axis. `low`: lower corner of the asset's box, in the file's units.
void guessAxis(const std::array<double, 3>& low, FrameGuess& guess) {
  const double y = upScoreOf(low, 1, guess), z = upScoreOf(low, 2, guess);
  guess.up = y > z ? 'y' : 'z';
  guess.doubtfulUp = y == z;
  guess.whyUp = y == z ? "the file does not show which axis is up"
                       : fmt::format("{} measures {:.3g} x {:.3g} x {:.3g} units, and starts at {:.3g} along {}",
                                     nameOf(guess.object), guess.extent[0], guess.extent[1], guess.extent[2],
                                     low[guess.up == 'y' ? 1 : 2], guess.up);
}

// Returns the nodes of a place that show objects whose concepts have usual sizes.
std::vector<SizedObject> sizedObjects(const Asset& asset, const std::vector<const Concept*>& partConcepts) {
  constexpr double kGreatest = 400;  // m; walls and fences, which may be longer, say little about the unit
  std::map<std::uint32_t, std::pair<const Concept*, Box>> objects;  // the keys are indices of nodes
  for (std::size_t i = 0; i < asset.parts.size(); ++i) {
    const Concept* const part = partConcepts[i];
    if (part == nullptr || part->kind != ConceptKind::Whole || !part->size || part->size->high > kGreatest) continue;
    auto& [shown, box] = objects[asset.parts[i].nodeIndex];
    shown = part;
    for (const Vec3f& p : asset.parts[i].positions) box.add(Vec3d(p));
  }
  std::vector<SizedObject> sized;
  for (const auto& [node, object] : objects) {
    const Vec3d size = object.second.high - object.second.low;
    sized.push_back({object.first, std::max({size.x, size.y, size.z})});
  }
  return sized;
}

// Returns an object of a place that would have an unusual size in metres; the unit is guessed from this object. Returns
// nothing unless a common unit gives usual sizes to most objects, and to more than twice as many objects as the metre.
std::optional<SizedObject> objectNotInMetres(const Asset& asset, const std::vector<const Concept*>& partConcepts) {
  std::vector<SizedObject> objects = sizedObjects(asset, partConcepts);
  const auto countFitting = [&](double unit) {
    return std::ranges::count_if(objects, [&](const SizedObject& object) { return fits(object, unit); });
  };
  const double best = *std::ranges::max_element(kUnits, {}, countFitting);
  if (countFitting(best) <= 2 * countFitting(1) || 2 * countFitting(best) <= std::ssize(objects)) return {};
  std::erase_if(objects, [&](const SizedObject& object) { return !fits(object, best); });
  // A node may hold many objects of one kind, such as all cars of a street; its size then says nothing about the unit.
  constexpr double kSeveral = 100;  // ratio of the longest edge to the usual size
  const bool oneKindOfMany = std::ranges::all_of(objects, [&](const SizedObject& object) {
    return object.shown == objects.front().shown && object.longest <= kSeveral * object.shown->size->high;
  });
  if (oneKindOfMany) return {};
  return *std::ranges::find_if(objects, [](const SizedObject& object) { return !fits(object, 1); });
}

// Returns the object or ground to which a part belongs: the object that its node's name states, otherwise the object
// that the file contains, otherwise the ground that the node's name states. Null: unknown.
const Concept* ownerOf(const Concept* node, const Concept* file) {
  for (const Concept* stated : {node, file}) {
    if (stated != nullptr && stated->kind == ConceptKind::Whole) return stated;
  }
  return node != nullptr && node->kind != ConceptKind::Detail ? node : nullptr;
}

// Returns the concept of one part; see guessParts() for the rules.
const Concept* guessPart(const Vocabulary& words, const AssetPart& part, const Concept* file) {
  const Concept* node = words.conceptOf(part.node);
  // A ground concept without classes, such as the concept of "World", says nothing about the part's class.
  if (node != nullptr && node->classes.empty() && node->kind == ConceptKind::Ground) node = nullptr;
  if (node != nullptr && node->kind == ConceptKind::Drop) return node;
  const Concept* const material = words.conceptOf(part.material);
  const Concept* const texture = words.conceptOf(textureStem(part));
  const Concept* const owner = ownerOf(node, file);
  for (const Concept* stated : {material, texture, node}) {
    if (const Concept* const detail = detailOf(words.concepts(), stated, owner)) return detail;
  }
  // If a ground has several materials, a material's name may state a different ground, which is more exact.
  if (owner != nullptr && owner->kind == ConceptKind::Ground) {
    for (const Concept* moreExact : {material, texture}) {
      if (moreExact != nullptr && moreExact->kind == ConceptKind::Ground) return moreExact;
    }
  }
  for (const Concept* stated : {owner, material, texture, node}) {
    if (stated != nullptr) return stated;
  }
  return file;
}

// Marks a stated unit as doubtful if it gives the object an unusual size.
void doubtUnit(FrameGuess& guess) {
  FrameGuess withoutStated = guess;
  guessUnit(withoutStated);
  if (withoutStated.whyUnit.empty()) return;
  const double unit = withoutStated.unit, longest = guess.object.longest;
  guess.doubtfulUnit = true;
  guess.whyUnit = unit == 1 ? withoutStated.whyUnit
                            : fmt::format("{} of {:.4g} m is unusual; `unit: {:g}` would make it {:.3g} m",
                                          nameOf(guess.object), longest, unit, longest * unit);
}

// Considers the files whose concepts have usual sizes. If at least `leastFiles` files do, and one unit gives usual
// sizes to most of them, sets this unit for all files and returns true; a file whose object this unit would make far
// too large or small gets its own unit. Otherwise returns false.
bool guessSharedUnit(const std::vector<FrameGuess*>& files, std::ptrdiff_t leastFiles) {
  constexpr double kMost = 0.8;  // fraction of the files that a shared unit must suit
  const auto sizedFiles = std::ranges::count_if(files, hasUsualSize, &FrameGuess::object);
  const auto countFitting = [&](double unit) {
    return std::ranges::count_if(
        files, [&](const SizedObject& o) { return hasUsualSize(o) && fits(o, unit); }, &FrameGuess::object);
  };
  double shared = 1;  // unit (m)
  for (const double unit : kUnits) {
    if (countFitting(unit) > countFitting(shared)) shared = unit;
  }
  const bool suitsMost = static_cast<double>(countFitting(shared)) >= kMost * static_cast<double>(sizedFiles);
  if (sizedFiles < leastFiles || !suitsMost) return false;
  for (FrameGuess* f : files) {
    const bool isSized = hasUsualSize(f->object);
    if (isSized && !fits(f->object, shared, kTolerance)) {
      guessUnit(*f);
      continue;
    }
    f->unit = shared;
    f->doubtfulUnit = isSized && !fits(f->object, shared);
    if (isSized && (shared != 1 || f->doubtfulUnit)) {
      f->whyUnit =
          fmt::format("{}; most similar files have plausible sizes with this unit", sizeWith(f->object, shared));
    } else if (shared != 1) {
      f->whyUnit = "as similar files";
    }
  }
  return true;
}

// Returns the files with the most common footprint, which are tiles of one set; nothing if they are fewer than three.
std::vector<FrameGuess*> tilesOf(const std::vector<FrameGuess*>& files) {
  constexpr std::size_t kFewest = 3;
  constexpr double kAlike = 0.1;  // largest difference of two lengths divided by the shorter
  const auto alike = [](double a, double b) { return std::fabs(a - b) <= kAlike * std::min(a, b); };
  // Returns a file's horizontal extent besides x: y, or z if the guessed up axis is not the axis assumed for reading.
  const auto depth = [](const FrameGuess* f) { return f->extent[f->up == f->readUp ? 1 : 2]; };
  std::vector<FrameGuess*> tiles;
  for (const FrameGuess* f : files) {
    if (!(f->extent[0] > 0)) continue;
    std::vector<FrameGuess*> sameFootprint;
    std::ranges::copy_if(files, std::back_inserter(sameFootprint), [&](const FrameGuess* other) {
      return alike(f->extent[0], other->extent[0]) && alike(depth(f), depth(other));
    });
    if (sameFootprint.size() > tiles.size()) tiles = std::move(sameFootprint);
  }
  return tiles.size() < kFewest ? std::vector<FrameGuess*>{} : tiles;
}

// Gives files with a doubtful up axis the axis of most other files.
void shareAxis(const std::vector<FrameGuess*>& files) {
  std::map<char, std::size_t> axes;  // for each axis, the number of files for which it was guessed without doubt
  for (const FrameGuess* f : files) {
    if (!f->whyUp.empty() && !f->doubtfulUp) ++axes[f->up];
  }
  if (axes.empty()) return;
  for (FrameGuess* f : files) {
    if (!f->doubtfulUp) continue;
    f->up = axes['y'] > axes['z'] ? 'y' : 'z';
    f->whyUp = "as other files of the folder";
    f->doubtfulUp = axes['y'] + axes['z'] < 2 || (axes['y'] > 0 && axes['z'] > 0);
  }
}

}  // namespace

std::vector<CountedPart> partsOf(const Asset& asset) {
  std::vector<CountedPart> parts;
  for (const AssetPart& part : asset.parts) parts.push_back({&part, 1});
  for (const InstancedParts& instanced : asset.instanced) {
    for (const AssetPart& part : instanced.parts) parts.push_back({&part, instanced.assetFromParts.size()});
  }
  return parts;
}

std::string folderName(const std::filesystem::path& file) {
  static constexpr std::array<std::string_view, 16> kContents{
      "mesh", "meshes", "model", "models", "visual", "visuals", "geometry", "source",
      "obj",  "dae",    "gltf",  "glb",    "fbx",    "stl",     "ply",      "ac"};
  std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  const std::string name = lowerCase(folder.filename().string());
  if (std::ranges::find(kContents, name) != kContents.end()) folder = folder.parent_path();
  return folder.filename().string();
}

void Vocabulary::ignoreShared(const std::vector<std::string>& names) {
  std::map<std::string, std::set<std::string>> namesWith;  // the folded names that contain each word
  std::set<std::string> distinctNames;                     // folded names, which have no digits
  for (const std::string& name : names) {
    const std::string folded = foldedName(name);
    if (folded.empty() || !distinctNames.insert(folded).second) continue;
    for (const std::string_view word : wordsOf(folded)) namesWith[std::string(word)].insert(folded);
  }
  std::set<std::string> sharedWords;
  for (const auto& [word, containing] : namesWith) {
    if (2 * containing.size() <= distinctNames.size()) continue;
    const Concept* const stated = conceptOf(word);
    if (stated == nullptr || stated->kind == ConceptKind::Drop) continue;
    std::vector<const Concept*> otherConcepts;  // the concepts that the names state without the word
    for (const std::string& name : containing) {
      const std::string otherWords = withoutWords(name, {word});
      otherConcepts.push_back(otherWords.empty() ? nullptr : conceptOf(otherWords));
    }
    if (isPlace(otherConcepts, stated)) sharedWords.insert(word);
  }
  ignored_.merge(sharedWords);
}

void Vocabulary::ignoreShared(const Asset& asset) {
  std::vector<std::string> nodes, materials, textures;
  for (const auto& [part, copies] : partsOf(asset)) {
    nodes.push_back(part->node);
    materials.push_back(part->material);
    textures.push_back(textureStem(*part));
  }
  for (const auto* names : {&nodes, &materials, &textures}) ignoreShared(*names);
}

std::string Vocabulary::tellingPart(std::string_view name) const {
  const std::string folded = foldedName(name);
  const std::string remaining = withoutWords(folded, ignored_);
  return remaining.empty() ? folded : remaining;
}

const Concept* Vocabulary::conceptOf(std::string_view name) const {
  return scanmill::conceptOf(concepts_, tellingPart(name));
}

std::vector<const Concept*> Vocabulary::conceptsIn(std::string_view name) const {
  return scanmill::conceptsIn(concepts_, tellingPart(name));
}

FileConcept conceptOfFile(const Vocabulary& words, const Asset& asset) {
  if (statesClasses(words, asset)) return {};
  const std::vector<const Concept*> parts = guessParts(words, asset, nullptr);
  const Concept* const file = words.conceptOf(asset.file.stem().string());
  if (file != nullptr) return {file->kind == ConceptKind::Whole && isPlace(parts, file) ? nullptr : file};
  const Concept* const folder = isPlace(parts) ? nullptr : words.conceptOf(folderName(asset.file));
  return {folder, folder != nullptr};
}

std::vector<const Concept*> guessParts(const Vocabulary& words, const Asset& asset, const Concept* file) {
  std::vector<const Concept*> guesses;
  for (const auto& [part, copies] : partsOf(asset)) guesses.push_back(guessPart(words, *part, file));
  return guesses;
}

FrameGuess guessFrame(const Asset& asset, const std::vector<const Concept*>& partConcepts) {
  FrameGuess guess;
  guess.up = asset.up;
  const Box box = boundsOf(asset);
  if (box.empty()) return guess;
  const std::array<double, 3> low{box.low.x, box.low.y, box.low.z};
  guess.extent = {box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z};
  guess.object.longest = *std::ranges::max_element(guess.extent);
  guess.readUp = asset.up;
  guess.statedUnit = asset.statedUnit > 0;
  guess.severalObjects = isPlace(partConcepts);
  if (!guess.severalObjects) guess.object.shown = mainConcept(asset, partConcepts);
  if (!asset.upDeclared) guessAxis(low, guess);
  if (guess.severalObjects) guess.object = objectNotInMetres(asset, partConcepts).value_or(guess.object);
  return guess;
}

void guessUnitsTogether(const std::vector<FrameGuess*>& files) {
  shareAxis(files);
  std::vector<FrameGuess*> withoutUnit;  // files that state no unit
  for (FrameGuess* f : files) {
    if (!f->statedUnit) {
      withoutUnit.push_back(f);
    } else if (hasUsualSize(f->object)) {
      doubtUnit(*f);
    }
  }
  if (guessSharedUnit(withoutUnit, 2)) return;
  const std::vector<FrameGuess*> tiles = tilesOf(withoutUnit);
  if (!tiles.empty() && guessSharedUnit(tiles, 1)) {
    std::erase_if(withoutUnit, [&](FrameGuess* f) { return std::ranges::count(tiles, f) > 0; });
    if (guessSharedUnit(withoutUnit, 2)) return;
  }
  for (FrameGuess* f : withoutUnit) {
    if (hasUsualSize(f->object)) guessUnit(*f);
  }
}

const Concept* groundIn(const Vocabulary& words, const std::filesystem::path& file) {
  // Grounds whose words have another meaning in names of objects: "sand" as a material, "water" and "floor" as a use,
  // as in "water tower" and "floor lamp".
  static constexpr std::array<std::string_view, 3> kAmbiguous{"sand", "water", "floor"};
  const std::vector<const Concept*> stated = words.conceptsIn(file.stem().string());
  const auto ground = std::ranges::find_if(stated, [](const Concept* c) {
    return c->kind == ConceptKind::Ground && !c->classes.empty() &&
           std::ranges::find(kAmbiguous, c->name) == kAmbiguous.end();
  });
  const bool namesObject = std::ranges::count(stated, ConceptKind::Whole, &Concept::kind) > 0;
  return namesObject && ground != stated.end() ? *ground : nullptr;
}

}  // namespace scanmill::draft
