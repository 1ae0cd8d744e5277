#include "town/layout.h"

namespace scanmill::town {
namespace {

using models::Footprint;
using models::smooth;

constexpr double kFarFromRoads = 1e3;  // m, distance that is assumed if no road is near
constexpr double kSoftEdge = 1.5;      // m beside hard ground, where unevenness and levelling fade in

// Returns pointers to the outline and the holes of an area.
std::vector<const Polygon*> ringsOf(const MapArea& area) {
  std::vector<const Polygon*> rings{&area.outline};
  for (const Polygon& hole : area.holes) rings.push_back(&hole);
  return rings;
}

}  // namespace

void Areas::add(MapArea area) {
  const auto [low, high] = extentOf(area.outline);
  static constexpr double kFarthest = 2000;  // m, farther than any town extends; bounds the number of cells
  const auto clamped = [](double v) { return std::clamp(v, -kFarthest, kFarthest); };
  cells_.add({clamped(low.x - kReach), clamped(low.y - kReach)}, {clamped(high.x + kReach), clamped(high.y + kReach)},
             0, static_cast<std::uint32_t>(areas_.size()));
  sizes_.push_back(areaOf(area.outline));
  areas_.push_back(std::move(area));
}

std::optional<Land> Areas::landAt(const Point2& p) const {
  const std::optional<std::uint32_t> index = indexAt(p);
  return index ? std::optional(areas_[*index].land) : std::nullopt;
}

std::optional<std::uint32_t> Areas::indexAt(const Point2& p) const {
  std::optional<std::uint32_t> index;
  double smallest = 1e18;
  for (const std::uint32_t i : cells_.at(p)) {
    if (sizes_[i] >= smallest || !isInside(ringsOf(areas_[i]), p)) continue;
    smallest = sizes_[i];
    index = i;
  }
  return index;
}

double Areas::outsideHard(const Point2& p) const {
  double least = kReach;
  for (const std::uint32_t i : cells_.at(p)) {
    const Land land = areas_[i].land;
    if (land != Land::Water && land != Land::Lot && land != Land::Paved) continue;
    const std::vector<const Polygon*> rings = ringsOf(areas_[i]);
    const double distance = distanceToRings(rings, p);
    least = std::min(least, isInside(rings, p) ? -distance : distance);
  }
  return least;
}

Layout::Layout(const Parameters& keys, std::uint64_t townSeed)
    : parameters(keys), seed(townSeed), character(keys, townSeed), about(character.inWords()), halfSide(reachOf(keys)) {
  drawRoads();
  drawRoundabout();
  drawPotholes();
  drawLand();
  addAllPlots();
  // After all plots, since plots come first on the ground that is left.
  for (const Plot& plot : plots) addRearBuildings(plot);
  setLevels();
}

double Layout::reachOf(const Parameters& parameters) {
  return parameters.length / 2 + kBeyond + kEdge;
}

bool Layout::nearPothole(const Point2& p, double reach) const {
  return std::ranges::any_of(potholeCells_.at(p), [&](std::uint32_t i) {
    const Pothole& hole = potholes[i];
    return std::hypot(p.x - hole.center.x, p.y - hole.center.y) < hole.radius + reach;
  });
}

// Adds `index` to the cells that may contain points within kPatchReach of the rectangle `f`.
void Layout::addToCells(const Footprint& f, std::uint32_t index, models::CellIndex& cells) {
  const double reach = std::hypot(f.halfX, f.halfY) + kPatchReach;
  const TurnedRectangle rectangle(f);
  const auto middle = [](double v) { return kPatchCell * (static_cast<double>(models::cellOf(v, kPatchCell)) + 0.5); };
  for (const double y : models::steps(f.center.y - reach, f.center.y + reach + kPatchCell, kPatchCell)) {
    for (const double x : models::steps(f.center.x - reach, f.center.x + reach + kPatchCell, kPatchCell)) {
      const double outside = rectangle.outside({middle(x), middle(y)});
      if (outside < kPatchReach + kPatchCell) cells.add({x, y}, index);
    }
  }
}

double Layout::outsidePatches(const Point2& p) const {
  double least = kPatchReach;
  for (const std::uint32_t i : patchCells_.at(p)) least = std::min(least, patches[i].rectangle.outside(p));
  return least;
}

const Patch* Layout::patchAt(const Point2& p) const {
  for (const std::uint32_t i : patchCells_.at(p)) {
    if (patches[i].rectangle.outside(p) < 0) return &patches[i];
  }
  return nullptr;
}

std::array<double, 5> Layout::borders(double edge, const CrossSection& section) {
  return {edge + section.parking, edge, edge - section.curb, edge - section.curb - section.verge,
          edge - section.paved()};
}

// Tests the strips of the road's cross section from the middle outwards, then the land beside the road.
GroundKind Layout::kindAt(const Beside& beside, const Point2& p) const {
  if (!beside.nearRoad) {
    const Patch* patch = patchAt(p);
    return patch != nullptr ? patch->kind : landAt(p);
  }
  const CrossSection& s = beside.section;
  if (beside.edge < 0) {
    constexpr double kLeastBay = 1.5;  // m, least width of a parking lane with a surface of its own
    return s.parking > kLeastBay && beside.edge > -s.parking ? GroundKind::Parking : GroundKind::Road;
  }
  if (beside.edge < s.curb) return GroundKind::Curb;
  if (const Patch* patch = patchAt(p)) {
    // Patches, such as driveways, do not interrupt the sidewalk.
    if (beside.edge < s.curb + s.verge || beside.edge > s.paved()) return patch->kind;
  }
  if (beside.edge < s.curb + s.verge) return s.sidewalk > 0 ? GroundKind::Verge : GroundKind::Shoulder;
  if (beside.edge > s.outer() && areas.landAt(p)) return landAt(p);
  return s.sidewalk > 0 && beside.edge < s.paved() ? GroundKind::Sidewalk : landAt(p);
}

// Returns the kind of ground where there is neither a road nor a patch.
GroundKind Layout::landAt(const Point2& p) const {
  if (areas.outsideHard(p) >= 0) return GroundKind::Lawn;
  const std::optional<Land> land = areas.landAt(p);
  if (land == Land::Water) return GroundKind::Water;
  if (land == Land::Lot) return GroundKind::Lot;
  return land == Land::Paved ? GroundKind::Paved : GroundKind::Lawn;
}

// Returns the height (m) of hills: a sum of three random fields, whose sizes (m) and weights are estimates.
double Layout::hillsAt(const Point2& p) const {
  return character.hills *
         (field(Field::Hills, p, 260) + 0.25 * field(Field::Slopes, p, 110) + 0.11 * field(Field::Knolls, p, 45));
}

// Returns a factor on the height of the curb: 1, or less where a driveway joins the road.
double Layout::lowering(const Beside& beside, const Point2& p) const {
  constexpr double kFarthest = 3;  // m from the road's edge; no driveway lowers the ground beyond
  if (beside.section.step <= 0 || beside.edge > kFarthest) return 1;
  constexpr double kLeast = 0.25;                        // the factor in the middle of a driveway
  constexpr double kRampAlong = 0.8, kRampAcross = 1.5;  // m, lengths of the slopes beside and along the driveway
  double factor = 1;
  for (const std::uint32_t i : patchCells_.at(p)) {
    if (patches[i].kind != GroundKind::Driveway) continue;
    const Footprint& f = patches[i].rectangle;
    const double across = std::abs((p.x - f.center.x) * std::cos(f.yaw) + (p.y - f.center.y) * std::sin(f.yaw));
    factor = std::min(factor, std::max(smooth((across - f.halfX) / kRampAlong), smooth(beside.edge / kRampAcross)));
  }
  return std::max(factor, kLeast);
}

// Returns the height (m) of the carriageway `inside` m from its edge: the sum of hills, crown, ruts and potholes.
double Layout::carriagewayHeight(double inside, const Point2& p) const {
  if (character.plain) return hillsAt(p);
  constexpr double kCamber = 0.02;      // slope across the road, an estimate
  constexpr double kCambered = 5;       // m from the road's edge to where the crown is level
  constexpr double kRuts = 0.012;       // m, amplitude of ruts about 7 m long
  constexpr double kWornSpots = 0.006;  // m, amplitude of worn spots about 1.7 m wide
  const double crown = kCamber * std::min(inside, kCambered);
  const double worn = kRuts * field(Field::Ruts, p, 7) + kWornSpots * field(Field::WornSpots, p, 1.7);
  double potholeDepth = 0;
  for (const std::uint32_t i : potholeCells_.at(p)) {
    const Pothole& hole = potholes[i];
    const double inwards = 1 - std::hypot(p.x - hole.center.x, p.y - hole.center.y) / hole.radius;
    potholeDepth = std::max(potholeDepth, hole.depth * smooth(2 * inwards));
  }
  return hillsAt(p) + crown + worn - potholeDepth;
}

// Returns the unevenness (m) of lawns and meadows. `edge`: m from the carriageway's edge; `hard`: outsideHard(p).
double Layout::rollingOfLand(const Beside& beside, double edge, double hard, const Point2& p) const {
  constexpr double kLawns = 9;  // m from pavements to where the unevenness is full
  const double unpaved = std::max(0.0, edge - (beside.nearRoad ? beside.section.paved() : 0));
  const double wild = character.undulation * smooth(unpaved / kLawns) * smooth(hard / kSoftEdge);
  return 1.6 * wild * field(Field::Swells, p, 16) + 0.6 * wild * field(Field::Bumps, p, 5);
}

// Returns the height (m) of banks beside roads. Parking lots and squares are flatter than the land around them.
double Layout::bankHeight(const Beside& beside, double edge, double hard, const Point2& p) const {
  constexpr double kBanks = 11;  // m from the curb to where a bank has its full height
  const double flat = 0.25 + 0.75 * smooth(hard / Areas::kReach);
  return flat * character.banks * smooth((edge - beside.section.curb) / kBanks) * field(Field::Banks, p, 45);
}

// Returns the fine unevenness (m) of the ground. The amplitude varies over the land and is smaller on paved kinds.
double Layout::grainOf(GroundKind kind, const Beside& beside, double edge, const Point2& p) const {
  const double rough = character.plain ? 0 : 0.03 + 0.08 * std::max(0.0, field(Field::Roughness, p, 9));
  const double paved = kind == GroundKind::Driveway || kind == GroundKind::Path ? 0.3 : 1.0;
  return rough * field(Field::Grain, p, 2.3) * smooth((edge - beside.section.curb) / 0.3) * paved *
         (kind == GroundKind::Sidewalk ? 0.1 : 1);
}

// The height of roads is carriagewayHeight(). Other heights are sums of terms that fade out at the borders of kinds.
double Layout::heightAt(GroundKind kind, const Beside& beside, const Point2& p) const {
  const double edge = beside.nearRoad ? beside.edge : kFarFromRoads;
  if (kind == GroundKind::Road || kind == GroundKind::Parking) return carriagewayHeight(-edge, p);
  const double hard = areas.outsideHard(p);
  const double outer = beside.nearRoad ? beside.section.outer() : 0;
  // The height of curb and pavement fades out far from roads; otherwise there would be a step where `nearRoad` changes.
  constexpr double kFadesFrom = 18, kFades = 15;  // m from the road's edge
  constexpr double kCrossfall = 0.015;            // slope of pavements towards the road
  const double near = beside.nearRoad ? 1 - smooth((edge - kFadesFrom) / kFades) : 0;
  const double curb = near * beside.section.step * lowering(beside, p);
  const double pavement = near * kCrossfall * std::clamp(edge, 0.0, outer);
  double natural =
      hillsAt(p) + curb + pavement + rollingOfLand(beside, edge, hard, p) + bankHeight(beside, edge, hard, p);
  if (kind == GroundKind::Water) {
    // Water is level, except within kBanks of its shore.
    constexpr double kBanks = 2;  // m, width of the slope at a shore
    const std::optional<std::uint32_t> area = areas.indexAt(p);
    if (area) natural += smooth(-hard / kBanks) * (waterLevels_[*area] - natural);
  }
  return natural + smooth((edge - outer) / kSoftEdge) * levelling(p, natural) +
         smooth(hard / kSoftEdge) * (grainOf(kind, beside, edge, p) + snowOn(beside, p));
}

// Returns the depth of snow (m): 0 on paved ground, which is cleared; larger on verges, where ploughs leave a bank.
double Layout::snowOn(const Beside& beside, const Point2& p) const {
  if (character.snow <= 0) return 0;
  const double cleared = smooth(outsidePatches(p) / 0.5);
  constexpr double kSlope = 0.3;  // m, width over which the depth rises at the edge of snow
  if (!beside.nearRoad) return character.snow * cleared;
  constexpr double kBank = 1.3, kLeastBank = 0.6;  // m, widths of the widest and the narrowest banks
  const CrossSection& s = beside.section;
  const double verge = beside.edge - s.curb;  // m, distance of the point beyond the curb
  double depth = character.snow * smooth((beside.edge - s.paved()) / kSlope);
  if (verge > 0 && verge < s.verge) {
    const bool pavement = s.sidewalk > 0.3;
    depth = character.snow * smooth(verge / kSlope) * (pavement ? smooth((s.verge - verge) / kSlope) : 1);
  }
  const double bank = std::min(kBank, s.verge);
  if (bank > kLeastBank && verge > 0 && verge < bank) {
    const double across = std::sin(kPi * verge / bank);
    const double along = 0.6 + 1.2 * field(Field::SnowHeaps, p, 3) + 0.6 * field(Field::SnowLumps, p, 0.8);
    depth += character.snowBanks * across * across * std::max(along, 0.1);
  }
  return depth * cleared;
}

// Returns the height (m) that must be added to `natural` to level the ground at buildings; 0 far from buildings.
double Layout::levelling(const Point2& p, double natural) const {
  double weightedSum = 0, sumOfWeights = 0, largestWeight = 0;
  for (const std::uint32_t i : terraceCells_.at(p)) {
    const double weight = 1 - smooth(terraces_[i].rectangle.outside(p) / kPatchReach);
    weightedSum += weight * (terraces_[i].height - natural);
    sumOfWeights += weight;
    largestWeight = std::max(largestWeight, weight);
  }
  return sumOfWeights > 0 ? largestWeight * weightedSum / sumOfWeights : 0;
}

double Layout::heightAt(const Point2& p) const {
  const Beside b = besideAt(p);
  return heightAt(kindAt(b, p), b, p);
}

}  // namespace scanmill::town
