#include "draft/guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <sstream>

#include "assets/meshes/asset_parts.h"
#include "config/text.h"

namespace scanmill::draft {
namespace {

// Returns the detail of `whole` that has the same words as the detail `named`; for instance, the wheels of a train
// instead of the wheels of a car. Null if there is none.
const Concept* detailOf(const std::vector<Concept>& concepts, const Concept* named, const Concept* whole) {
  if (named == nullptr || whole == nullptr || named->kind != ConceptKind::Detail) return nullptr;
  for (const Concept& c : concepts) {
    const bool same = c.kind == ConceptKind::Detail && c.words == named->words;
    if (same && std::find(c.of.begin(), c.of.end(), whole->name) != c.of.end()) return &c;
  }
  return nullptr;
}

// Returns the concept with the most triangles. If this concept is a detail, such as wheels, and the asset also has
// wholes, such as a car, returns the whole with the most triangles.
const Concept* mainConcept(const Asset& asset, const std::vector<const Concept*>& parts) {
  std::map<const Concept*, std::size_t> triangles;
  std::map<const Concept*, std::size_t> ofWholes;
  for (std::size_t i = 0; i < parts.size() && i < asset.parts.size(); ++i) {
    const std::size_t count = asset.parts[i].triangles.size();
    triangles[parts[i]] += count;
    if (parts[i] != nullptr && parts[i]->kind == ConceptKind::Whole) ofWholes[parts[i]] += count;
  }
  const auto mostOf = [](const auto& counts) {
    return std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  };
  if (triangles.empty()) return nullptr;
  const Concept* const most = mostOf(triangles)->first;
  const bool detail = most != nullptr && most->kind == ConceptKind::Detail;
  return detail && !ofWholes.empty() ? mostOf(ofWholes)->first : most;
}

// True if the parts, and the file's name if `file` is not null, state at least three different objects and grounds. The
// file then contains a place, such as a room, and not one object. Walls and doors of a file that is called a house are
// the house's, since they may have its class.
bool isPlace(const std::vector<const Concept*>& parts, const Concept* file = nullptr) {
  constexpr std::size_t kSeveral = 3;
  std::set<const Concept*> kinds;
  if (file != nullptr) kinds.insert(file);
  for (const Concept* c : parts) {
    if (c == nullptr || (c->kind != ConceptKind::Whole && c->kind != ConceptKind::Ground)) continue;
    const bool ofFile = file != nullptr && !file->classes.empty() &&
                        std::find(c->classes.begin(), c->classes.end(), file->classes.front()) != c->classes.end();
    if (!ofFile) kinds.insert(c);
  }
  return kinds.size() >= kSeveral;
}

// True if the file itself states classes, as labelled point clouds do. A single class without a known word does not
// count, since programs write one number for all points that nobody classified.
bool statesClasses(const Vocabulary& words, const Asset& asset) {
  std::set<std::string> classes;
  for (const AssetPart& part : asset.parts) classes.insert(part.ownClass);
  classes.erase("");
  return classes.size() > 1 || (!classes.empty() && words.conceptOf(*classes.begin()) != nullptr);
}

// Splits a folded name at its blanks.
std::vector<std::string> wordsOf(const std::string& folded) {
  std::istringstream stream(folded);
  return {std::istream_iterator<std::string>(stream), {}};
}

// Returns a folded name without some words.
std::string without(const std::string& folded, const std::set<std::string>& ignored) {
  std::string rest;
  for (const std::string& word : wordsOf(folded)) {
    if (!ignored.contains(word)) rest += (rest.empty() ? "" : " ") + word;
  }
  return rest;
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
// up axis and are centred along the other axes. Trees are tall; cars, grounds and places are low.
double upScoreOf(const std::array<double, 3>& low, const std::array<double, 3>& extent, std::size_t axis,
                 const FrameGuess& guess) {
  constexpr double kAtZero = 0.03, kThin = 0.1;  // fractions of the extent along the axis and of the longest extent
  constexpr double kCentred = 0.1;               // fraction of the extent along the other axis
  double score = 0;
  const double longest = *std::ranges::max_element(extent);
  if (longest <= 0) return 0;
  if (std::abs(low[axis]) <= kAtZero * std::max(extent[axis], kThin * longest)) score += 1;
  const std::size_t other = axis == 1 ? 2 : 1;
  const double middle = low[other] + extent[other] / 2;
  if (std::abs(middle) <= kCentred * extent[other]) score += 0.5;
  if (guess.severalObjects && extent[axis] < extent[other]) score += 2;
  if (guess.unitConcept == nullptr) return score;
  if (isTall(*guess.unitConcept) && extent[axis] > extent[other]) score += 2;
  if (isFlat(*guess.unitConcept) && extent[axis] < extent[other]) score += 2;
  return score;
}

// Common units besides the metre, in metres.
constexpr std::array<double, 8> kUnits{0.01, 0.0254, 0.3048, 0.001, 0.1, 10.0, 100.0, 1000.0};
// Factor by which a size may be outside of its usual range if other files suggest the unit.
constexpr double kTolerance = 3;

std::string nameOf(const FrameGuess& guess) {
  return guess.unitConcept == nullptr ? "it" : "a " + guess.unitConcept->name;
}

// True if the file, with this unit in metres, has the usual size of its concept or a size that is outside by at most
// the factor `factor`. The concept must have a usual size.
bool fits(const FrameGuess& guess, double unit, double factor) {
  const Range& usual = *guess.unitConcept->size;
  return Range{usual.low / factor, usual.high * factor}.contains(guess.longest * unit);
}

std::string sizeWith(const FrameGuess& guess, double unit) {
  return fmt::format("{} of {:.3g} units is {:.3g} m with this unit, and {:g} to {:g} m are usual", nameOf(guess),
                     guess.longest, guess.longest * unit, guess.unitConcept->size->low, guess.unitConcept->size->high);
}

// Sets the unit of a file: metres if its concept then has a usual size, otherwise the common unit that gives a usual
// size nearest to the middle of the range. If no unit does, keeps metres and marks them as doubtful.
void guessUnit(FrameGuess& guess) {
  if (fits(guess, 1, 1)) return;
  const Range& usual = *guess.unitConcept->size;
  double nearest = 1e9;
  for (const double unit : kUnits) {
    const double off = std::abs(std::log(guess.longest * unit / std::sqrt(usual.low * usual.high)));
    if (!fits(guess, unit, 1) || off >= nearest) continue;
    nearest = off;
    guess.unit = unit;
    guess.whyUnit = sizeWith(guess, unit);
  }
  if (guess.unit != 1) return;
  guess.doubtfulUnit = true;
  guess.whyUnit = fmt::format("{} of {:.3g} m is unusual, but no common unit gives {:g} to {:g} m", nameOf(guess),
                              guess.longest, usual.low, usual.high);
}

// Sets the up axis, unless the file or its kind states it.
void guessAxis(const std::array<double, 3>& low, const std::array<double, 3>& extent, FrameGuess& guess) {
  const double y = upScoreOf(low, extent, 1, guess), z = upScoreOf(low, extent, 2, guess);
  guess.up = y > z ? 'y' : 'z';
  guess.doubtfulUp = y == z;
  guess.whyUp =
      y == z ? "the file does not show which axis is up"
             : fmt::format("{} measures {:.3g} x {:.3g} x {:.3g} units, and starts at {:.3g} along {}", nameOf(guess),
                           extent[0], extent[1], extent[2], low[guess.up == 'y' ? 1 : 2], guess.up);
}

// Returns for each node of a place that is an object of usual size its concept and its longest edge.
std::vector<FrameGuess> sizedObjects(const Asset& asset, const std::vector<const Concept*>& parts) {
  constexpr double kGreatest = 400;  // m; walls and fences, which may be longer, say little about the unit
  std::map<std::uint32_t, std::pair<const Concept*, Box>> objects;  // by node
  for (std::size_t i = 0; i < asset.parts.size(); ++i) {
    if (parts[i] == nullptr || parts[i]->kind != ConceptKind::Whole || !parts[i]->size) continue;
    if (parts[i]->size->high > kGreatest) continue;
    auto& [shown, box] = objects[asset.parts[i].nodeIndex];
    shown = parts[i];
    for (const Vec3f& p : asset.parts[i].positions) box.add(Vec3d(p));
  }
  std::vector<FrameGuess> sized;
  for (const auto& [node, object] : objects) {
    const Vec3d size = object.second.high - object.second.low;
    FrameGuess& one = sized.emplace_back();
    one.unitConcept = object.first;
    one.longest = std::max({size.x, size.y, size.z});
  }
  return sized;
}

// Sets `unitConcept` and `longest` to an object of a place, by whose size the unit is then guessed, if a common unit
// gives most objects usual sizes, and more than twice as many as metres do.
void measureObjects(const Asset& asset, const std::vector<const Concept*>& parts, FrameGuess& guess) {
  const std::vector<FrameGuess> objects = sizedObjects(asset, parts);
  const auto fitting = [&](double unit) {
    std::vector<FrameGuess> found;
    std::ranges::copy_if(objects, std::back_inserter(found), [&](const FrameGuess& one) { return fits(one, unit, 1); });
    return found;
  };
  std::vector<FrameGuess> best = fitting(1);
  const std::size_t inMetres = best.size();
  for (const double unit : kUnits) {
    if (std::vector<FrameGuess> found = fitting(unit); found.size() > best.size()) best = std::move(found);
  }
  if (best.size() <= 2 * inMetres || 2 * best.size() <= objects.size()) return;
  // A node may hold many objects of one kind, such as all cars of a street, and is then larger than one of them.
  constexpr double kSeveral = 100;  // ratio of the longest edge to the usual size
  const bool oneKindOfMany = std::ranges::none_of(best, [&](const FrameGuess& one) {
    return one.unitConcept != best.front().unitConcept || one.longest > kSeveral * one.unitConcept->size->high;
  });
  if (oneKindOfMany) return;
  const FrameGuess& notInMetres = *std::ranges::find_if(best, [](const FrameGuess& one) { return !fits(one, 1, 1); });
  guess.unitConcept = notInMetres.unitConcept;
  guess.longest = notInMetres.longest;
}

// Returns the object or ground to which a part belongs: what its node's name states or, unless this is an object, the
// object that the file contains. Null: unknown.
const Concept* ownerOf(const Concept* node, const Concept* file) {
  const bool stated = node != nullptr && node->kind != ConceptKind::Detail;
  if (stated && node->kind == ConceptKind::Whole) return node;
  if (file != nullptr && file->kind == ConceptKind::Whole) return file;
  return stated ? node : nullptr;
}

const Concept* guessPart(const Vocabulary& words, const AssetPart& part, const Concept* file) {
  const Concept* node = words.conceptOf(part.node);
  // A concept of ground without classes, such as that of the name "World", says nothing about the part's class.
  if (node != nullptr && node->classes.empty() && node->kind == ConceptKind::Ground) node = nullptr;
  if (node != nullptr && node->kind == ConceptKind::Drop) return node;
  const Concept* const material = words.conceptOf(part.material);
  const Concept* const texture = words.conceptOf(textureStem(part));
  const Concept* const owner = ownerOf(node, file);
  for (const Concept* named : {material, texture, node}) {
    if (const Concept* const detail = detailOf(words.concepts(), named, owner)) return detail;
  }
  // If a ground has several materials, a material's name may state a different ground, which is more exact.
  if (owner != nullptr && owner->kind == ConceptKind::Ground) {
    for (const Concept* finer : {material, texture}) {
      if (finer != nullptr && finer->kind == ConceptKind::Ground) return finer;
    }
  }
  for (const Concept* known : {owner, material, texture, node}) {
    if (known != nullptr) return known;
  }
  return file;
}

bool isSized(const FrameGuess* guess) {
  return guess->unitConcept != nullptr && guess->unitConcept->size && guess->longest > 0;
}

// Marks a stated unit as doubtful if the size of the file's concept is unusual.
void doubtUnit(FrameGuess& guess) {
  FrameGuess free = guess;
  guessUnit(free);
  if (free.whyUnit.empty()) return;
  guess.doubtfulUnit = true;
  guess.whyUnit = free.unit == 1 ? free.whyUnit
                                 : fmt::format("{} of {:.4g} m is unusual; `unit: {:g}` would make it {:.3g} m",
                                               nameOf(guess), guess.longest, free.unit, guess.longest * free.unit);
}

// Considers the files whose concepts have usual sizes. If there are at least `fewest`, and one unit gives usual sizes
// to at least the fraction `most` of them, sets this unit for all files and returns true; files that it would make far
// too large or small get a unit of their own. Otherwise returns false.
bool guessSharedUnit(const std::vector<FrameGuess*>& files, double most, std::ptrdiff_t fewest) {
  const auto sized = std::count_if(files.begin(), files.end(), isSized);
  const auto fitting = [&](double unit) {
    return std::ranges::count_if(files, [&](const FrameGuess* f) { return isSized(f) && fits(*f, unit, 1); });
  };
  double shared = 1;
  for (const double unit : kUnits) {
    if (fitting(unit) > fitting(shared)) shared = unit;
  }
  if (sized < fewest || static_cast<double>(fitting(shared)) < most * static_cast<double>(sized)) return false;
  for (FrameGuess* f : files) {
    if (isSized(f) && !fits(*f, shared, kTolerance)) {
      guessUnit(*f);
      continue;
    }
    f->unit = shared;
    f->doubtfulUnit = isSized(f) && !fits(*f, shared, 1);
    if (isSized(f) && (shared != 1 || f->doubtfulUnit)) {
      f->whyUnit = fmt::format("{}; most similar files have plausible sizes with this unit", sizeWith(*f, shared));
    } else if (shared != 1) {
      f->whyUnit = "as similar files";
    }
  }
  return true;
}

// Returns the files that are tiles of one set: those with the most common footprint, if there are at least three.
// Otherwise returns nothing.
std::vector<FrameGuess*> tilesOf(const std::vector<FrameGuess*>& files) {
  constexpr std::size_t kFewest = 3;
  constexpr double kAlike = 0.1;
  const auto alike = [](double a, double b) { return std::fabs(a - b) <= kAlike * std::min(a, b); };
  const auto depth = [](const FrameGuess* f) { return f->extent[f->up == f->readUp ? 1 : 2]; };
  std::vector<FrameGuess*> most;
  for (const FrameGuess* f : files) {
    std::vector<FrameGuess*> same;
    for (FrameGuess* other : files) {
      const bool fit = alike(f->extent[0], other->extent[0]) && alike(depth(f), depth(other));
      if (fit && f->extent[0] > 0) same.push_back(other);
    }
    if (same.size() > most.size()) most = std::move(same);
  }
  return most.size() < kFewest ? std::vector<FrameGuess*>{} : most;
}

// Gives files with a doubtful up axis the axis of most other files.
void shareAxis(const std::vector<FrameGuess*>& all) {
  std::map<char, std::size_t> axes;
  for (const FrameGuess* f : all) {
    if (!f->whyUp.empty() && !f->doubtfulUp) ++axes[f->up];
  }
  if (axes.empty()) return;
  for (FrameGuess* f : all) {
    if (!f->doubtfulUp) continue;
    f->up = axes['y'] > axes['z'] ? 'y' : 'z';
    f->whyUp = "as other files of the folder";
    f->doubtfulUp = axes['y'] + axes['z'] < 2 || (axes['y'] > 0 && axes['z'] > 0);
  }
}

void guessUnitOfEach(const std::vector<FrameGuess*>& files) {
  for (FrameGuess* f : files) {
    if (isSized(f)) guessUnit(*f);
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
  const std::string own = lowerCase(folder.filename().string());
  if (std::ranges::find(kContents, own) != kContents.end()) folder = folder.parent_path();
  return folder.filename().string();
}

void Vocabulary::ignoreShared(const std::vector<std::string>& names) {
  std::map<std::string, std::set<std::string>> holders;  // names with a word
  std::set<std::string> different;                       // distinct folded names, which have no digits
  for (const std::string& name : names) {
    const std::string folded = foldedName(name);
    if (folded.empty() || !different.insert(folded).second) continue;
    for (const std::string& word : wordsOf(folded)) holders[word].insert(folded);
  }
  std::set<std::string> shared;
  for (const auto& [word, holding] : holders) {
    if (2 * holding.size() <= different.size()) continue;
    const Concept* const what = conceptOf(word);
    if (what == nullptr || what->kind == ConceptKind::Drop) continue;
    std::vector<const Concept*> others;
    for (const std::string& name : holding) {
      const std::string rest = without(name, {word});
      others.push_back(rest.empty() ? nullptr : conceptOf(rest));
    }
    if (isPlace(others, what)) shared.insert(word);
  }
  ignored_.merge(shared);
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
  const std::string rest = without(folded, ignored_);
  return rest.empty() ? folded : rest;
}

const Concept* Vocabulary::conceptOf(std::string_view name) const {
  return scanmill::conceptOf(concepts_, tellingPart(name));
}

std::vector<const Concept*> Vocabulary::conceptsIn(std::string_view name) const {
  return scanmill::conceptsIn(concepts_, tellingPart(name));
}

const Concept* conceptOfFile(const Vocabulary& words, const Asset& asset) {
  if (statesClasses(words, asset)) return nullptr;
  const Concept* const file = words.conceptOf(asset.file.stem().string());
  const bool ofOneObject = file != nullptr && file->kind == ConceptKind::Whole;
  return ofOneObject && isPlace(guessParts(words, asset, nullptr), file) ? nullptr : file;
}

const Concept* conceptOfFolder(const Vocabulary& words, const Asset& asset) {
  if (statesClasses(words, asset) || words.conceptOf(asset.file.stem().string()) != nullptr) return nullptr;
  return isPlace(guessParts(words, asset, nullptr)) ? nullptr : words.conceptOf(folderName(asset.file));
}

std::vector<const Concept*> guessParts(const Vocabulary& words, const Asset& asset, const Concept* file) {
  std::vector<const Concept*> guesses;
  for (const auto& [part, copies] : partsOf(asset)) guesses.push_back(guessPart(words, *part, file));
  return guesses;
}

FrameGuess guessFrame(const Asset& asset, const std::vector<const Concept*>& parts) {
  FrameGuess guess;
  guess.up = asset.up;
  const Box box = boundsOf(asset);
  if (box.empty()) return guess;
  const std::array<double, 3> low{box.low.x, box.low.y, box.low.z};
  guess.extent = {box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z};
  guess.longest = *std::ranges::max_element(guess.extent);
  guess.readUp = asset.up;
  guess.statedUnit = asset.statedUnit > 0;
  guess.severalObjects = isPlace(parts);
  if (!guess.severalObjects) guess.unitConcept = mainConcept(asset, parts);
  if (!asset.upDeclared) guessAxis(low, guess.extent, guess);
  if (guess.severalObjects) measureObjects(asset, parts, guess);
  return guess;
}

void guessUnitsTogether(const std::vector<FrameGuess*>& all) {
  shareAxis(all);
  std::vector<FrameGuess*> files;  // those that state no unit
  for (FrameGuess* f : all) {
    if (!f->statedUnit) {
      files.push_back(f);
    } else if (isSized(f)) {
      doubtUnit(*f);
    }
  }
  constexpr double kMost = 0.8;  // fraction of the files that a shared unit must suit
  if (guessSharedUnit(files, kMost, 2)) return;
  const std::vector<FrameGuess*> tiles = tilesOf(files);
  if (tiles.empty() || !guessSharedUnit(tiles, kMost, 1)) return guessUnitOfEach(files);
  std::vector<FrameGuess*> others;
  std::ranges::copy_if(files, std::back_inserter(others),
                       [&](FrameGuess* f) { return std::ranges::find(tiles, f) == tiles.end(); });
  if (!guessSharedUnit(others, kMost, 2)) guessUnitOfEach(others);
}

const Concept* groundIn(const Vocabulary& words, const std::filesystem::path& file) {
  const Concept* ground = nullptr;
  bool namesObject = false;
  // Concepts whose words have another meaning in names of objects: "sand" and "stone" as a material, "water" and
  // "floor" as a use, as in "water tower" and "floor lamp".
  static constexpr std::array<std::string_view, 3> kOfThings{"sand", "water", "floor"};
  for (const Concept* c : words.conceptsIn(file.stem().string())) {
    const bool ofThings = std::ranges::find(kOfThings, c->name) != kOfThings.end();
    if (c->kind == ConceptKind::Ground && !c->classes.empty() && !ofThings && ground == nullptr) ground = c;
    namesObject = namesObject || c->kind == ConceptKind::Whole;
  }
  return namesObject ? ground : nullptr;
}

}  // namespace scanmill::draft
