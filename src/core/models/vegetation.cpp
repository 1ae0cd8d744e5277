// Builds trees, bushes and hedges. Leaves are small folded polygons, so that no alpha testing is needed. Leaves are
// denser towards the outside of a crown. A polygon is about 15 cm long and represents several leaves. Its area is half
// of its length times its width: crowns have a leaf area index of 2 to 3.

#include <algorithm>
#include <cmath>

#include "models/models.h"

namespace scanmill::models {
namespace {

// The look of a species of trees.
struct Habit {
  const char* name;
  bool conifer;
  double height, crownBase, crownRadius;  // m
  double trunkRadius;                     // m
  int clusters;                           // number of clusters of leaves
  double clusterSize;                     // radius of a cluster as a fraction of the crown's radius
  int leaves;                             // number of leaf polygons
  double leafLength;                      // m, mean length of a leaf polygon
  const char* bark = "bark";
};

constexpr double kGoldenAngle = 2.39996;  // rad; its multiples are spread evenly over the circle
constexpr double kBareBelow = 0.6;        // twigs are added if `foliage` is smaller

// Typical trees along streets, by eye. Heights and crown radii vary by up to 12 % with the seed.
constexpr std::array<Habit, kTreeForms> kHabits{{
    {"lime", false, 9.4, 2.2, 2.7, 0.10, 31, 0.42, 5400, 0.20, "bark_dark"},
    {"maple", false, 7.5, 1.9, 2.3, 0.085, 25, 0.45, 5000, 0.20, "bark_light"},
    {"oak", false, 11.4, 2.4, 4.0, 0.16, 42, 0.38, 6300, 0.25, "bark_dark"},
    {"poplar", false, 14.0, 1.0, 1.5, 0.12, 36, 0.60, 5400, 0.19},
    {"birch", false, 9.8, 1.9, 1.9, 0.07, 34, 0.40, 4500, 0.16, "bark_light"},
    {"apple", false, 4.6, 1.1, 1.9, 0.07, 20, 0.45, 3800, 0.16},
    {"spruce", true, 12.0, 0.9, 2.4, 0.13, 0, 0, 5600, 0.32},
    {"pine", true, 9.0, 1.6, 2.2, 0.12, 0, 0, 4800, 0.30},
}};

// Returns the material of the leaves of a plant's form. The forms of a kind differ in how bright they are.
const char* leavesOf(int form) {
  constexpr std::array kLeaves{"leaf", "leaf_light", "leaf_dark"};
  return kLeaves[static_cast<std::size_t>(form) % kLeaves.size()];
}

// Appends a pointed leaf of two triangles, folded along its midrib. `normal` is normal to the plane of the leaf.
void appendLeaf(Shape& s, SurfaceIndex surface, const Vec3d& stem, const Vec3d& tip, const Vec3d& normal,
                double width) {
  const Vec3d axis = tip - stem;
  const Vec3d across = normalized(cross(normal, axis)) * (width / 2);
  const Vec3d fold = normalized(normal) * (width * 0.12);
  const Vec3d middle = stem + axis * 0.45 + fold;
  s.quad(surface, stem, middle - across, tip, middle + across);
}

// Returns a random unit vector perpendicular to `normal`.
Vec3d crossways(const Vec3d& normal, Draw& draw) {
  return normalized(cross(normal, draw.direction()));
}

// Appends leaves in the outer part of an ellipsoid and, so that few beams pass it, larger ones inside. `flatness`: the
// ellipsoid's height divided by its width.
void appendFoliageBall(Shape& s, SurfaceIndex surface, Draw& draw, const Vec3d& center, double radius, double flatness,
                       int leaves, double leafLength) {
  constexpr int kInnerEvery = 5;                      // one leaf of so many is inside
  constexpr double kInside = 0.65, kInnerLength = 2;  // of the radius; times the length of the others
  for (int k = 0; k < leaves; ++k) {
    const bool isInner = k % kInnerEvery == 0;
    const Vec3d out = draw.direction();
    const double r = radius * (isInner ? kInside * std::cbrt(draw.next()) : 0.7 + 0.3 * std::pow(draw.next(), 0.4));
    const Vec3d position = center + Vec3d{out.x * r, out.y * r, out.z * r * flatness};
    const Vec3d normal = normalized(out * 0.6 + Vec3d{0, 0, 0.3} + draw.direction() * 0.7);
    Vec3d axis = crossways(normal, draw);
    if (axis.z > 0) axis = -axis;  // leaves point downwards
    const double size = draw.around(leafLength, 0.3) * (isInner ? kInnerLength : 1);
    appendLeaf(s, surface, position - axis * (size / 2), position + axis * (size / 2), normal,
               size * draw.in(0.55, 0.75));
  }
}

// Returns the crown's radius at the height `t` (0: base, 1: top), as a fraction of the crown's largest radius.
double crownProfile(const Habit& habit, double t) {
  const bool column = habit.crownRadius < 0.15 * habit.height;
  return column ? 0.55 + 0.45 * std::sin(kPi * std::min(1.0, t * 0.9 + 0.15))
                : std::sqrt(std::sin(kPi * (t * 0.86 + 0.1)));
}

// Appends a cluster's twigs, which are visible when leaves have fallen. `twigRadius`: radius at a twig's start (m).
void appendTwigs(Shape& s, SurfaceIndex surface, Draw& draw, const Vec3d& center, double radius, int count,
                 double twigRadius) {
  for (int k = 0; k < count; ++k) {
    const Vec3d begin = center + draw.direction() * (radius * draw.in(0, 0.5));
    const Vec3d out = normalized(draw.direction() + normalized(begin - center + Vec3d{0, 0, 0.01}) + Vec3d{0, 0, 0.4});
    s.tube(surface, begin, begin + out * (radius * draw.in(0.4, 0.8)), twigRadius, 0.003, 3);
  }
}

// The irregularity of a crown. A separate random stream leaves the random values of regular crowns unchanged.
class Raggedness {
 public:
  // `irregularity`: from 0 to 1, see makeTree().
  Raggedness(std::uint64_t seed, int form, double irregularity)
      : irregularity_(irregularity), draw_(seed, Kind::Crown, form) {
    heavySide_ = draw_.in(0, 2 * kPi);
    longAxis_ = draw_.in(0, 2 * kPi);
  }

  // Returns a factor on the distance from the trunk to a cluster of leaves. `angle`: azimuth of the cluster (rad).
  double reach(double angle) const {
    return 1 + irregularity_ * (0.3 * std::cos(angle - heavySide_) + 0.22 * std::cos(2 * (angle - longAxis_)));
  }
  // Returns a random factor on the radius of a cluster.
  double size() { return lerp(1, draw_.in(0.45, 1.4), irregularity_); }
  // Returns the random vertical offset of a cluster, as a fraction of the crown's height.
  double raised() { return irregularity_ * draw_.in(-0.13, 0.13); }
  bool missing() { return draw_.chance(0.22 * irregularity_); }

 private:
  double irregularity_;
  Draw draw_;
  double heavySide_ = 0, longAxis_ = 0;  // azimuths, rad
};

// The axis of a trunk: evenly spaced points from the ground upwards.
struct TrunkAxis {
  std::vector<Vec3d> points;

  // Returns the axis's point at the height `z` (m). Above or below the axis, returns the axis's upper or lower end.
  Vec3d at(double z) const {
    const std::size_t segments = points.size() - 1;
    const double t = std::clamp((z - points.front().z) / (points.back().z - points.front().z), 0.0, 1.0) *
                     static_cast<double>(segments);
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(t), segments - 1);
    return points[i] + (points[i + 1] - points[i]) * (t - double(i));
  }
};

// A ball of leaves in a crown (m).
struct Cluster {
  Vec3d center;
  double radius;
};

// Appends a slightly leaning and bent trunk and returns its axis. The crown begins at z = `base` and is `crown` m high.
TrunkAxis appendTrunk(Shape& s, Draw& draw, const Habit& habit, double base, double crown) {
  constexpr int kSegments = 7;
  const double leanX = draw.in(-0.25, 0.25);
  const double leanY = draw.in(-0.25, 0.25);
  TrunkAxis axis;
  std::vector<double> radii;
  for (int i = 0; i <= kSegments; ++i) {
    const double t = double(i) / kSegments;
    const double z = -0.15 + t * (base + crown * 0.75);
    axis.points.push_back({leanX * t * t + draw.in(-0.03, 0.03), leanY * t * t + draw.in(-0.03, 0.03), z});
    radii.push_back(habit.trunkRadius * (i == 0 ? 1.35 : lerp(1.0, 0.18, t)));
  }
  s.pipe(s.surface("trunk", habit.bark), axis.points, radii, 12);
  return axis;
}

// Returns a broadleaf's clusters in a spiral upwards. The crown begins at z = `base`; `crown`, `radius`: its size (m).
std::vector<Cluster> drawClusters(Draw& draw, const Habit& habit, const TrunkAxis& trunk, double base, double crown,
                                  double radius, Raggedness ragged) {
  std::vector<Cluster> clusters;
  for (int i = 0; i < habit.clusters; ++i) {
    const double t = (i + draw.next()) / habit.clusters;  // 0 at the crown's lower end, 1 at its top
    const double size = radius * habit.clusterSize * draw.in(0.8, 1.25) * ragged.size();
    const double angle = i * kGoldenAngle + draw.in(-0.5, 0.5);
    const double out =
        std::max(0.0, radius * crownProfile(habit, t) - size) * draw.in(0.75, 1.05) * ragged.reach(angle);
    const double z = base + size * 0.5 + t * std::max(0.1, crown - size * 1.3) + ragged.raised() * crown;
    if (ragged.missing()) continue;
    const Vec3d center = trunk.at(z) + Vec3d{out * std::cos(angle), out * std::sin(angle), 0};
    clusters.push_back({{center.x, center.y, z}, size});
  }
  return clusters;
}

// Appends a broadleaf: the trunk, and for each cluster a branch, twigs and leaves. `leaves`: material; `radius`: crown
// radius (m).
void appendBroadleaf(Shape& s, Draw& draw, const Habit& habit, const char* leaves, double height, double radius,
                     double foliage, const Raggedness& ragged) {
  const double base = habit.crownBase * height / habit.height;
  const double crown = height - base;
  const TrunkAxis trunk = appendTrunk(s, draw, habit, base, crown);
  const auto [branch, leaf] = s.surfaces("tree", habit.bark, leaves);
  const std::vector<Cluster> clusters = drawClusters(draw, habit, trunk, base, crown, radius, ragged);
  double squares = 0;  // sum of squared radii; each cluster has leaves in proportion to its squared radius
  for (const Cluster& c : clusters) squares += c.radius * c.radius;
  for (const Cluster& c : clusters) {
    const double fork = std::max(base * 0.85, c.center.z - 0.35 * crown * draw.in(0.5, 1.0) - 0.2);  // m, height
    const Vec3d begin = trunk.at(fork);
    const Vec3d middle = begin + (c.center - begin) * 0.55 + Vec3d{0, 0, -0.12 * length(c.center - begin)};
    const double branchRadius = habit.trunkRadius * lerp(0.42, 0.2, (fork - base) / crown);
    s.pipe(branch, {begin, middle, c.center}, {branchRadius, branchRadius * 0.65, branchRadius * 0.3}, 6);
    for (int k = 0; k < 3; ++k) {
      const Vec3d twig = normalized(draw.direction() + Vec3d{0, 0, 0.4});
      s.tube(branch, c.center, c.center + twig * (c.radius * 0.8), branchRadius * 0.25, 0.006, 4);
    }
    if (foliage < kBareBelow) appendTwigs(s, branch, draw, c.center, c.radius, 24, 0.008);
    appendFoliageBall(s, leaf, draw, c.center, c.radius, 0.8,
                      static_cast<int>(foliage * habit.leaves * c.radius * c.radius / squares), habit.leafLength);
  }
}

// A branch of a conifer, from the trunk outwards (m). `reach`: horizontal length of the branch.
struct Bough {
  Vec3d root, tip;
  double reach;
};

// Returns the boughs of a conifer, in whorls from z = `base` to the tree's top at z = `height`. `radius`: crown radius.
std::vector<Bough> drawBoughs(Draw& draw, double base, double height, double radius) {
  constexpr double kWhorlDistance = 0.42;  // m
  std::vector<Bough> boughs;
  double z = base;
  while (z < height - 0.25) {
    const double t = (z - base) / (height - base);
    const double reach = radius * std::pow(1 - t, 0.85) * draw.in(0.9, 1.1) + 0.12;
    const int count = t < 0.8 ? 9 : 6;
    const double firstAngle = draw.in(0, 2 * kPi);
    for (int k = 0; k < count; ++k) {
      const double angle = firstAngle + 2 * kPi * k / count + draw.in(-0.2, 0.2);
      const double out = reach * draw.in(0.8, 1.08);
      const double slope = lerp(-0.28, 0.45, t);
      const double rootZ = z + draw.in(-0.5, 0.5) * kWhorlDistance;
      boughs.push_back({{0, 0, rootZ}, {out * std::cos(angle), out * std::sin(angle), rootZ + slope * out}, out});
    }
    z += kWhorlDistance * draw.in(0.8, 1.2);
  }
  return boughs;
}

// Appends a conifer: a trunk, and boughs with needles on both sides. `height`: tree height; `radius`: crown radius (m).
void appendConifer(Shape& s, Draw& draw, const Habit& habit, double height, double radius) {
  const SurfaceIndex bark = s.surface("trunk", "bark");
  const auto [branch, needles] = s.surfaces("tree", "bark", "leaf_conifer");
  s.pipe(bark, {{0, 0, -0.15}, {0, 0, 0.3}, {0.04, 0.02, height * 0.5}, {0, 0, height - 0.1}},
         {habit.trunkRadius * 1.3, habit.trunkRadius, habit.trunkRadius * 0.55, 0.015}, 12);
  const std::vector<Bough> boughs = drawBoughs(draw, habit.crownBase * height / habit.height, height, radius);
  double totalReach = 0;  // m, sum over all boughs; the number of needles on a bough is proportional to its reach
  for (const Bough& b : boughs) totalReach += b.reach;
  for (const Bough& b : boughs) {
    s.tube(branch, b.root, b.tip, 0.022, 0.006, 4);
    const Vec3d along = b.tip - b.root;
    const Vec3d side = normalized(cross(along, Vec3d{0, 0, 1}));
    const int count = static_cast<int>(habit.leaves * b.reach / totalReach);
    for (int k = 0; k < count; ++k) {
      const double t = 1.02 - 0.85 * std::pow(draw.next(), 1.4);  // more needles near the tip
      const double size = draw.around(habit.leafLength, 0.3) * lerp(1.25, 0.8, t);
      const Vec3d stem = b.root + along * t + Vec3d{0, 0, draw.in(-0.05, 0.05)};
      const double sign = draw.sign();
      const double aside = sign * draw.in(0.5, 1.1);
      const double up = draw.in(-0.4, 0.15);
      const Vec3d tip = normalized(along) * 0.6 + side * aside + Vec3d{0, 0, up};
      const Vec3d normal = normalized(Vec3d{0, 0, 1} + draw.direction() * 0.6);
      appendLeaf(s, needles, stem, stem + normalized(tip) * size, normal, size * 0.42);
    }
  }
}

// Returns where a point of a straight hedge is in a hedge that was cut long ago: its sides bulge by about 0.1 m and its
// top is uneven. The waves repeat after 2 m along x, the length of a hedgerow, so that rows of them have no steps.
Vec3d inHedge(const Vec3d& p) {
  const double bulge = 1 + 0.12 * std::sin(2 * kPi * p.x + 3 * p.z) + 0.1 * std::sin(3 * kPi * p.x - 4 * p.z);
  return {p.x, p.y * bulge, p.z * (1 + 0.05 * std::sin(2 * kPi * p.x))};
}

// Appends the inside of a hedgerow, which beams do not pass: a closed body 0.14 m below the outermost leaves.
void appendHedgeCore(Shape& s, SurfaceIndex leaf, double height, double depth) {
  constexpr double kBelowLeaves = 0.14;                 // m
  constexpr int kAlong = 16, kAround = 28, kSide = 11;  // intervals along x, around the body, and of one side
  std::vector<std::vector<Vec3d>> rows;
  for (int i = -1; i <= kAlong + 1; ++i) {  // the first and the last row close the ends
    const bool atEnd = i < 0 || i > kAlong;
    std::vector<Vec3d>& row = rows.emplace_back();
    for (int k = 0; k <= kAround; ++k) {
      const double z = (height - kBelowLeaves) * std::min(1.0, double(std::min(k, kAround - k)) / kSide);
      // `across` falls from 1 at the left side to -1 at the right side.
      const double across = std::clamp((kAround - 2.0 * k) / (kAround - 2 * kSide), -1.0, 1.0);
      const double y = (depth / 2 - kBelowLeaves) * across;
      row.push_back(inHedge({2.0 * std::clamp(i, 0, kAlong) / kAlong - 1, atEnd ? 0 : y, z}));
    }
  }
  s.grid(rows, Loop::Open, leaf);
}

}  // namespace

TreeModel makeTree(SceneBuilder& builder, std::uint64_t seed, int form, double detail, double foliage, double ragged) {
  Habit habit = kHabits[static_cast<std::size_t>(form % kTreeForms)];
  habit.leaves = static_cast<int>(habit.leaves * detail);
  habit.leafLength /= std::sqrt(detail);
  Draw draw(seed, Kind::Tree, form);
  Shape s(builder, habit.name);
  const double height = draw.around(habit.height, 0.12);
  const double radius = draw.around(habit.crownRadius, 0.12);
  const auto leaves = static_cast<std::size_t>(habit.leaves);
  s.mesh.positions.reserve(5 * leaves);  // four vertices for each leaf, the rest for branches
  s.mesh.triangles.reserve(3 * leaves);
  s.mesh.surfaceOf.reserve(3 * leaves);
  habit.conifer ? appendConifer(s, draw, habit, height, radius)
                : appendBroadleaf(s, draw, habit, leavesOf(form), height, radius, foliage, {seed, form, ragged});
  const Model model = s.finish();
  const auto& [low, high] = model.bounds;
  return {model, std::max({-low.x, -low.y, high.x, high.y})};
}

Model makeBush(SceneBuilder& builder, std::uint64_t seed, int form, double foliage) {
  Draw draw(seed, Kind::Bush, form);
  Shape s(builder, "bush");
  const auto [leaf, bark] = s.surfaces("vegetation", leavesOf(form), "bark");
  const double size = draw.in(0.5, 0.95);  // m, about the bush's radius
  const int balls = 4 + draw.below(4);     // balls of leaves; the first ball is in the middle and on top
  for (int i = 0; i < balls; ++i) {
    const double angle = i * kGoldenAngle + draw.in(-0.4, 0.4);
    const double r = size * draw.in(0.42, 0.6);
    const double out = i == 0 ? 0 : size * draw.in(0.35, 0.55);
    const Vec3d center{out * std::cos(angle), out * std::sin(angle), (i == 0 ? size * 1.1 : size * draw.in(0.5, 0.9))};
    s.tube(bark, {0, 0, -0.05}, center, 0.02, 0.006, 5);
    if (foliage < kBareBelow) appendTwigs(s, bark, draw, center, r, 20, 0.004);
    appendFoliageBall(s, leaf, draw, center, r, 0.9, static_cast<int>(foliage * 1000 / balls), 0.1);
  }
  return s.finish();
}

Model makeHedgerow(SceneBuilder& builder, std::uint64_t seed, int form) {
  Draw draw(seed, Kind::Hedgerow, form);
  Shape s(builder, "hedge");
  const auto [leaf, bark] = s.surfaces("vegetation", leavesOf(form), "bark");
  const double height = draw.in(0.9, 2.4);
  const double depth = draw.in(0.6, 1.3);
  for (int k = 0; k < 6; ++k) {
    const Vec3d root{draw.in(-0.95, 0.95), draw.in(-0.1, 0.1), -0.1};
    const Vec3d tip{root.x + draw.in(-0.2, 0.2), draw.in(-0.3, 0.3) * depth, height * draw.in(0.6, 0.9)};
    s.tube(bark, root, tip, 0.02, 0.006, 5);
  }
  appendHedgeCore(s, leaf, height, depth);
  constexpr double kLength = 2;                        // m, length of the hedgerow
  constexpr double kLeafWidth = 0.7, kLeafArea = 0.5;  // a leaf's width / length, and its area / (length * width)
  constexpr double kLeafCover = 1.7;                   // area of all leaves / area of the hedgerow's side
  constexpr int kMostLeaves = 1750;
  const double leafLength = draw.in(0.09, 0.14);  // m, on average
  const double areaOfLeaf = kLeafArea * kLeafWidth * leafLength * leafLength;
  const int leaves = static_cast<int>(kLeafCover * kLength * height / areaOfLeaf);
  for (int k = 0; k < std::min(leaves, kMostLeaves); ++k) {
    const double across = draw.in(-1, 1);
    const double outwards = std::copysign(std::pow(std::abs(across), 0.3), across);  // most leaves are at the sides
    const double z = height * (1 - std::pow(draw.next(), 1.2) * 0.98);
    const Vec3d position = inHedge({draw.in(-1.03, 1.03), outwards * depth / 2, z});
    const Vec3d out{0, across, z > 0.85 * height ? 1.0 : 0.2};
    const Vec3d normal = normalized(out + draw.direction() * 0.5);
    const Vec3d axis = crossways(normal, draw);
    const double length = draw.around(leafLength, 0.3);
    appendLeaf(s, leaf, position - axis * (length / 2), position + axis * (length / 2), normal, length * kLeafWidth);
  }
  return s.finish();
}

Model makeUndergrowth(SceneBuilder& builder, std::uint64_t seed, int form, double foliage) {
  Draw draw(seed, Kind::Undergrowth, form);
  Shape s(builder, "undergrowth");
  const auto [leaf, bark] = s.surfaces("vegetation", leavesOf(form), "bark");
  const double height = draw.in(1.4, 3.2);
  const double radius = draw.in(1.1, 1.8);
  const int balls = 6 + draw.below(5);
  for (int i = 0; i < balls; ++i) {
    const double angle = i * kGoldenAngle + draw.in(-0.5, 0.5);
    const double r = draw.in(0.45, 0.75);
    const double out = radius * std::sqrt(draw.next()) * 0.8;
    const Vec3d center{out * std::cos(angle), out * std::sin(angle), lerp(0.35, height - r, draw.next())};
    s.tube(bark, {0.3 * center.x, 0.3 * center.y, -0.1}, center, 0.025, 0.006, 5);
    if (foliage < kBareBelow) appendTwigs(s, bark, draw, center, r, 30, 0.005);
    appendFoliageBall(s, leaf, draw, center, r, 0.9, static_cast<int>(foliage * 1900 / balls), 0.17);
  }
  return s.finish();
}

}  // namespace scanmill::models
