#include "scene/draft/guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "scene/assets/asset_parts.h"

namespace scanmill::draft {
namespace {

bool isDetailOf(const Concept* detail, const Concept* whole) {
  return detail != nullptr && whole != nullptr && detail->kind == ConceptKind::Detail &&
         std::find(detail->of.begin(), detail->of.end(), whole->name) != detail->of.end();
}

const Concept* first(std::initializer_list<const Concept*> candidates) {
  for (const Concept* c : candidates) {
    if (c != nullptr) return c;
  }
  return nullptr;
}

// The concept that most of the triangles have.
const Concept* mainConcept(const Asset& asset, const std::vector<const Concept*>& parts) {
  std::map<const Concept*, std::size_t> triangles;
  for (std::size_t i = 0; i < parts.size() && i < asset.parts.size(); ++i) {
    triangles[parts[i]] += asset.parts[i].triangles.size();
  }
  const auto most = std::max_element(triangles.begin(), triangles.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == triangles.end() ? nullptr : most->first;
}

// Whether the parts are of so many things and grounds that the file is a place, such as a room, and none of them.
bool isPlace(const std::vector<const Concept*>& parts) {
  constexpr std::size_t kSeveral = 3;
  std::set<const Concept*> kinds;
  for (const Concept* c : parts) {
    if (c != nullptr && (c->kind == ConceptKind::Whole || c->kind == ConceptKind::Ground)) kinds.insert(c);
  }
  return kinds.size() >= kSeveral;
}

bool isTall(const Concept& c) {
  static constexpr std::array<std::string_view, 7> kTall{"tree",         "trunk",         "pole",  "street lamp",
                                                         "traffic sign", "traffic light", "person"};
  return std::find(kTall.begin(), kTall.end(), c.name) != kTall.end();
}

bool isFlat(const Concept& c) {
  static constexpr std::array<std::string_view, 4> kLow{"car", "truck", "bus", "other vehicle"};
  return c.kind == ConceptKind::Ground || std::find(kLow.begin(), kLow.end(), c.name) != kLow.end();
}

// How much speaks for y or z being up: what stands begins at 0 and is centred along the other axes; trees are tall,
// cars, grounds and places low.
double scoreOf(const std::array<double, 3>& low, const std::array<double, 3>& extent, std::size_t axis,
               const Concept* what, bool place) {
  double score = 0;
  const double most = std::max({extent[0], extent[1], extent[2]});
  if (most <= 0) return 0;
  if (std::abs(low[axis]) <= 0.03 * std::max(extent[axis], 0.1 * most)) score += 1;
  const std::size_t other = axis == 1 ? 2 : 1;
  const double middle = low[other] + extent[other] / 2;
  if (std::abs(middle) <= 0.1 * extent[other]) score += 0.5;
  if (place && extent[axis] < extent[other]) score += 2;
  if (what == nullptr) return score;
  if (isTall(*what) && extent[axis] > extent[other]) score += 2;
  if (isFlat(*what) && extent[axis] < extent[other]) score += 2;
  return score;
}

}  // namespace

const Concept* conceptOfFile(const std::vector<Concept>& concepts, const std::filesystem::path& file) {
  const Concept* found = conceptOf(concepts, file.stem().string());
  std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  for (int up = 0; up < 2 && found == nullptr; ++up, folder = folder.parent_path()) {
    found = conceptOf(concepts, folder.filename().string());
  }
  return found;
}

std::vector<const Concept*> guessParts(const std::vector<Concept>& concepts, const Asset& asset) {
  const Concept* const file = conceptOfFile(concepts, asset.file);
  const auto guess = [&](const AssetPart& part) -> const Concept* {
    const Concept* const node = conceptOf(concepts, part.node);
    const Concept* const material = conceptOf(concepts, part.material);
    const Concept* const texture =
        conceptOf(concepts, std::filesystem::path(textureName(part.texture)).stem().string());
    if (node != nullptr && node->kind == ConceptKind::Drop) return node;
    const Concept* whole = node != nullptr && node->kind != ConceptKind::Detail ? node : nullptr;
    if (file != nullptr && file->kind == ConceptKind::Whole &&
        (whole == nullptr || whole->kind != ConceptKind::Whole)) {
      whole = file;
    }
    for (const Concept* detail : {material, texture, node}) {
      if (isDetailOf(detail, whole)) return detail;
    }
    // A ground of several materials says by them what it is where.
    if (whole != nullptr && whole->kind == ConceptKind::Ground) {
      for (const Concept* finer : {material, texture}) {
        if (finer != nullptr && finer->kind == ConceptKind::Ground) return finer;
      }
    }
    return first({whole, material, texture, node, file});
  };
  std::vector<const Concept*> guesses;
  for (const AssetPart& part : asset.parts) guesses.push_back(guess(part));
  for (const InstancedParts& instanced : asset.instanced) {
    for (const AssetPart& part : instanced.parts) guesses.push_back(guess(part));
  }
  return guesses;
}

FrameGuess guessFrame(const Asset& asset, const std::vector<const Concept*>& parts) {
  FrameGuess guess;
  guess.up = asset.up;
  const Box box = boundsOf(asset);
  if (box.empty()) return guess;
  const std::array<double, 3> low{box.low.x, box.low.y, box.low.z};
  const std::array<double, 3> extent{box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z};
  const bool place = isPlace(parts);
  const Concept* const what = place ? nullptr : mainConcept(asset, parts);
  const std::string name = what == nullptr ? "it" : "a " + what->name;
  if (!asset.upDeclared) {
    const double y = scoreOf(low, extent, 1, what, place);
    const double z = scoreOf(low, extent, 2, what, place);
    guess.up = y > z ? 'y' : 'z';
    guess.whyUp = y == z ? "nothing tells which axis is up"
                         : fmt::format("{} is {:.3g} x {:.3g} x {:.3g} units large, and begins at {:.3g} along {}",
                                       name, extent[0], extent[1], extent[2], low[guess.up == 'y' ? 1 : 2], guess.up);
  }
  // A world is as large as any; so is what no word names.
  if (what == nullptr || !what->size) return guess;
  const double longest = std::max({extent[0], extent[1], extent[2]});
  if (what->size->holds(longest)) return guess;
  // The common unit that brings it nearest to the middle of what is usual.
  double nearest = 1e9;
  for (const double unit : {0.01, 0.0254, 0.3048, 0.001, 0.1, 10.0, 100.0, 1000.0}) {
    const double off = std::abs(std::log(longest * unit / std::sqrt(what->size->low * what->size->high)));
    if (!what->size->holds(longest * unit) || off >= nearest) continue;
    nearest = off;
    guess.unit = unit;
    guess.whyUnit = fmt::format("{} of {:.3g} units is {:.3g} m with it, usual are {:g} to {:g} m", name, longest,
                                longest * unit, what->size->low, what->size->high);
  }
  if (guess.unit != 1) return guess;
  guess.whyUnit = fmt::format("{} of {:.3g} m is unusual, but no common unit makes it {:g} to {:g} m", name, longest,
                              what->size->low, what->size->high);
  return guess;
}

}  // namespace scanmill::draft
