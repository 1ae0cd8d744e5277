#include "study/noise/plane_motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>
#include <optional>

namespace scanmill {

namespace {

constexpr std::size_t kFewest = 50;        // matched pieces
constexpr double kMostError = 0.02;        // m, of the translation
constexpr double kLeastHeld = 0.005;       // see heldShare(): what the noise of the normals may hold in appearance
constexpr double kFarthestShift = 3;       // m, along either horizontal axis
constexpr double kShiftStep = 0.25;        // m
constexpr std::size_t kSearched = 300;     // pieces of the source that the search for a start looks at
constexpr std::size_t kStarts = 4;         // best shifts that are followed
constexpr std::size_t kFollowed = 1000;    // pieces of the source that are followed
constexpr double kLeastAgreement = 0.966;  // cosine between normals: 15 deg
constexpr double kFirstScale = 0.3;        // m, of the weights
constexpr double kLastScale = 0.03;        // m
constexpr double kScaleFall = 0.7;         // per step

double square(double value) {
  return value * value;
}

// What nanoflann asks of a set of points.
struct Centers {
  const std::vector<PlanePiece>& pieces;

  std::size_t kdtree_get_point_count() const { return pieces.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const Vec3d& c = pieces[i].center;
    return axis == 0 ? c.x : axis == 1 ? c.y : c.z;
  }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

// A piece of the source on its plane of the target.
struct Match {
  Vec3d point;   // the source's center, moved
  Vec3d normal;  // of the target
  double distance = 0;
};

using Vec6 = std::array<double, 6>;  // turn, shift

// Symmetric and positive definite, or there is no factor: Cholesky's.
class Normal6 {
 public:
  void add(const Vec6& row, double weight) {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j <= i; ++j) lower_[i][j] += weight * row[i] * row[j];
    }
  }
  void damp(std::size_t i, double by) { lower_[i][i] += by; }

  bool factor() {
    for (std::size_t i = 0; i < 6; ++i) {
      const double whole = lower_[i][i];
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = lower_[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= lower_[i][k] * lower_[j][k];
        if (i != j) {
          lower_[i][j] = sum / lower_[j][j];
        } else if (!(sum > 1e-12 * whole)) {
          return false;
        } else {
          lower_[i][i] = std::sqrt(sum);
        }
      }
    }
    return true;
  }

  Vec6 solve(Vec6 b) const {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= lower_[i][k] * b[k];
      b[i] /= lower_[i][i];
    }
    for (std::size_t i = 6; i-- > 0;) {
      for (std::size_t k = i + 1; k < 6; ++k) b[i] -= lower_[k][i] * b[k];
      b[i] /= lower_[i][i];
    }
    return b;
  }

 private:
  std::array<Vec6, 6> lower_{};
};

// Every n-th.
std::vector<PlanePiece> thinned(const std::vector<PlanePiece>& pieces, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, pieces.size() / most);
  std::vector<PlanePiece> kept;
  for (std::size_t i = 0; i < pieces.size(); i += stride) kept.push_back(pieces[i]);
  return kept;
}

struct Followed {
  Pose pose;
  bool still = false;  // the steps vanished
};

class PlaneMatcher {
 public:
  explicit PlaneMatcher(const std::vector<PlanePiece>& target)
      : target_(target), centers_{target}, tree_(3, centers_) {}

  // Of the nearest pieces the first that faces the same way, is beside the point and not off by more than `gate`.
  std::optional<Match> match(const PlanePiece& piece, const Pose& pose, const Mat3& rotation, double gate) const {
    constexpr std::size_t kNear = 8;
    const Vec3d point = rotation * piece.center + pose.translation;
    const Vec3d normal = rotation * piece.normal;
    std::array<std::size_t, kNear> near{};
    std::array<double, kNear> squares{};
    const double query[] = {point.x, point.y, point.z};
    const std::size_t found = tree_.knnSearch(query, kNear, near.data(), squares.data());
    for (std::size_t i = 0; i < found; ++i) {
      const PlanePiece& other = target_[near[i]];
      if (dot(normal, other.normal) < kLeastAgreement) continue;
      const double distance = dot(other.normal, point - other.center);
      if (std::abs(distance) > gate || squares[i] - square(distance) > square(other.reach)) continue;
      return Match{point, other.normal, distance};
    }
    return {};
  }

  std::vector<Match> matches(const std::vector<PlanePiece>& source, const Pose& pose, double gate) const {
    const Mat3 rotation = toMatrix(pose.rotation);
    std::vector<Match> found;
    for (const PlanePiece& piece : source) {
      if (const auto one = match(piece, pose, rotation, gate)) found.push_back(*one);
    }
    return found;
  }

  // How many pieces lie on planes, those that are off by more than `scale` counting less and less.
  double agreement(const std::vector<PlanePiece>& source, const Pose& pose, double scale) const {
    double sum = 0;
    for (const Match& m : matches(source, pose, 3 * scale)) sum += weight(m, scale);
    return sum;
  }

  Followed follow(const std::vector<PlanePiece>& source, Pose pose, double scale) const {
    constexpr int kMostSteps = 80;
    constexpr double kStillShift = 2e-4;  // m
    constexpr double kStillTurn = 1e-5;   // rad
    for (int step = 0; step < kMostSteps; ++step) {
      Normal6 normal;
      Vec6 right{};
      for (const Match& m : matches(source, pose, 3 * scale)) {
        const Vec6 row = rowOf(m);
        normal.add(row, weight(m, scale));
        for (std::size_t i = 0; i < 6; ++i) right[i] -= weight(m, scale) * m.distance * row[i];
      }
      // What no plane holds does not run away: a step of 1 m or 0.1 rad is as unlikely as being off by a scale.
      for (std::size_t i = 0; i < 6; ++i) normal.damp(i, square(scale / (i < 3 ? 0.1 : 1)));
      if (!normal.factor()) break;
      const Vec6 change = normal.solve(right);
      const Vec3d turn{change[0], change[1], change[2]};
      const Vec3d shift{change[3], change[4], change[5]};
      const double angle = length(turn);
      const Vec3d axis = angle > 0 ? turn * (std::sin(angle / 2) / angle) : Vec3d{};
      pose = Pose{{std::cos(angle / 2), axis.x, axis.y, axis.z}, shift} * pose;
      if (scale <= kLastScale && angle < kStillTurn && length(shift) < kStillShift) return {pose, true};
      scale = std::max(kLastScale, scale * kScaleFall);
    }
    return {pose, false};
  }

  // Standard error of the translation (m); infinite where a direction is free.
  double errorAt(const std::vector<Match>& found) const {
    Normal6 normal;
    double squares = 0;
    double weights = 0;
    for (const Match& m : found) {
      const double w = weight(m, kLastScale);
      normal.add(rowOf(m), w);
      squares += w * square(m.distance);
      weights += w;
    }
    if (weights <= 6 || !normal.factor()) return INFINITY;
    double variance = 0;
    for (std::size_t i = 3; i < 6; ++i) {
      Vec6 unit{};
      unit[i] = 1;
      variance += normal.solve(unit)[i];
    }
    return std::sqrt(variance * squares / (weights - 6));
  }

 private:
  static double weight(const Match& m, double scale) { return 1 / (1 + square(m.distance / scale)); }
  static Vec6 rowOf(const Match& m) {
    const Vec3d turn = cross(m.point, m.normal);
    return {turn.x, turn.y, turn.z, m.normal.x, m.normal.y, m.normal.z};
  }

  const std::vector<PlanePiece>& target_;
  Centers centers_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Centers>, Centers, 3, std::size_t> tree_;
};

// Mean square of the normals' parts along the direction in which they point least, or up to three times less. Normals
// of noisy patches point a little everywhere, so that even a lone wall seems to hold what it does not.
double heldShare(const std::vector<Match>& found) {
  Mat3 sum{{}, {}, {}};
  for (const Match& m : found) {
    sum.x += m.normal * m.normal.x;
    sum.y += m.normal * m.normal.y;
    sum.z += m.normal * m.normal.z;
  }
  const double count = static_cast<double>(found.size());
  if (!(determinant(sum) > 1e-9 * count * count * count)) return 0;
  const Mat3 other = inverse(sum);
  return 1 / (count * (other.x.x + other.y.y + other.z.z));
}

// The shifts at which the most pieces lie on planes, best first.
std::vector<Pose> startsFor(const PlaneMatcher& matcher, const std::vector<PlanePiece>& source) {
  struct Shift {
    double agreement;
    Pose pose;
  };
  constexpr int kSteps = static_cast<int>(kFarthestShift / kShiftStep);
  std::vector<Shift> shifts;
  for (int x = -kSteps; x <= kSteps; ++x) {
    for (int y = -kSteps; y <= kSteps; ++y) {
      const Pose pose{{}, {x * kShiftStep, y * kShiftStep, 0}};
      shifts.push_back({matcher.agreement(source, pose, kShiftStep / 2), pose});
    }
  }
  std::stable_sort(shifts.begin(), shifts.end(),
                   [](const Shift& a, const Shift& b) { return a.agreement > b.agreement; });
  std::vector<Pose> starts;
  for (std::size_t i = 0; i < kStarts; ++i) starts.push_back(shifts[i].pose);
  return starts;
}

}  // namespace

PlaneMotion registerPlanes(const std::vector<PlanePiece>& source, const std::vector<PlanePiece>& target) {
  PlaneMotion motion;
  motion.failure = fmt::format("fewer than {} flat patches in common", kFewest);
  if (source.size() < kFewest || target.size() < kFewest) return motion;
  const PlaneMatcher matcher(target);
  const std::vector<PlanePiece> some = thinned(source, kFollowed);
  Pose best;
  double most = -1;
  for (const Pose& start : startsFor(matcher, thinned(source, kSearched))) {
    const Pose end = matcher.follow(some, start, kFirstScale).pose;
    const double agreement = matcher.agreement(some, end, kLastScale);
    if (agreement <= most) continue;
    most = agreement;
    best = end;
  }
  const Followed last = matcher.follow(source, best, kLastScale);
  const std::vector<Match> found = matcher.matches(source, last.pose, 3 * kLastScale);
  motion.targetFromSource = last.pose;
  motion.matched = found.size();
  if (found.size() < kFewest) return motion;
  motion.error = matcher.errorAt(found);
  if (!std::isfinite(motion.error) || heldShare(found) < kLeastHeld) {
    motion.failure = "the planes leave a direction free";
  } else if (motion.error > kMostError) {
    motion.failure = fmt::format("the planes hold the shift to {:.2g} m only", motion.error);
  } else if (!last.still) {
    motion.failure = "the steps did not vanish";
  } else {
    motion.failure.clear();
  }
  return motion;
}

}  // namespace scanmill
