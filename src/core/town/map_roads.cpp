// Joins the roads of a map, which consist of many short ways, into the roads that a driver would follow.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/vec.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

constexpr double kSharpest = 2.4;  // rad, largest change of direction at a point within a joined road

// An end of a piece of a road: 0 is its start, 1 its end.
struct End {
  std::size_t piece;
  int end;
};

struct Piece {
  MapRoad road;
  // The ends of the pieces that continue this piece at its start and at its end; not set: no piece does.
  std::optional<End> next[2];
};

double turnAt(const MapRoad& road, std::size_t i) {
  const Point2& a = road.line[i - 1];
  const Point2& b = road.line[i];
  const Point2& c = road.line[i + 1];
  return std::abs(wrapped(std::atan2(c.y - b.y, c.x - b.x) - std::atan2(b.y - a.y, b.x - a.x)));
}

// Cuts roads into pieces: at crossings, and where a road turns back on itself.
std::vector<Piece> cut(const std::vector<MapRoad>& roads) {
  std::map<std::int64_t, int> uses;
  for (const MapRoad& road : roads) {
    for (const std::int64_t node : road.nodes) ++uses[node];
  }
  std::vector<Piece> pieces;
  for (const MapRoad& road : roads) {
    MapRoad without = road;  // a road may have thousands of pieces
    without.line.clear();
    without.nodes.clear();
    std::size_t from = 0;
    for (std::size_t i = 1; i < road.line.size(); ++i) {
      if (i + 1 < road.line.size() && uses[road.nodes[i]] < 2 && turnAt(road, i) < kSharpest) continue;
      Piece piece{without, {}};
      piece.road.line.assign(road.line.begin() + static_cast<std::ptrdiff_t>(from),
                             road.line.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      piece.road.nodes.assign(road.nodes.begin() + static_cast<std::ptrdiff_t>(from),
                              road.nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      pieces.push_back(std::move(piece));
      from = i;
    }
  }
  return pieces;
}

// Returns the direction (rad) in which a road leaves one of its ends, averaged over the kReach metres after this end.
double headingFrom(const MapRoad& road, int end) {
  constexpr double kReach = 12;  // m, length over which the direction is averaged
  const std::size_t count = road.line.size();
  const auto at = [&](std::size_t i) { return road.line[end == 0 ? i : count - 1 - i]; };
  const Point2 start = at(0);
  std::size_t i = 1;
  while (i + 1 < count && std::hypot(at(i).x - start.x, at(i).y - start.y) < kReach) ++i;
  return std::atan2(at(i).y - start.y, at(i).x - start.x);
}

// Returns how poorly two pieces with a common node fit together as one road (lower is better); nullopt if they cannot
// be one road.
std::optional<double> misfit(const std::vector<Piece>& pieces, const End& a, const End& b, bool alone) {
  const MapRoad& p = pieces[a.piece].road;
  const MapRoad& q = pieces[b.piece].road;
  if (p.ring != q.ring || p.oneWay != q.oneWay) return std::nullopt;
  if (p.oneWay && a.end == b.end) return std::nullopt;
  const double difference = headingFrom(p, a.end) - headingFrom(q, b.end);
  const double turn = std::abs(kPi - std::abs(wrapped(difference)));
  const bool sameName = !p.name.empty() && p.name == q.name;
  const bool minor = p.kind >= RoadClass::Service;
  if (minor != (q.kind >= RoadClass::Service) && !sameName) return std::nullopt;
  // Outside of roundabouts, a road continues around a sharp corner only if its name and class stay the same
  // and no other road joins it there.
  const bool corner = p.ring || (alone && p.kind == q.kind && p.name == q.name);
  if (turn > (corner ? kSharpest : 0.8)) return std::nullopt;
  return turn + (sameName ? 0 : 0.5) + 0.3 * std::abs(static_cast<int>(p.kind) - static_cast<int>(q.kind));
}

void match(std::vector<Piece>& pieces) {
  std::map<std::int64_t, std::vector<End>> meetings;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const MapRoad& road = pieces[i].road;
    meetings[road.nodes.front()].push_back({i, 0});
    meetings[road.nodes.back()].push_back({i, 1});
  }
  struct Pair {
    double misfit;
    End a, b;
  };
  constexpr std::size_t kMostEnds = 100;  // more ends than any junction has; each pair of ends is compared
  for (const auto& [node, ends] : meetings) {
    if (ends.size() > kMostEnds) continue;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      for (std::size_t j = i + 1; j < ends.size(); ++j) {
        if (ends[i].piece == ends[j].piece && ends.size() > 2) continue;
        const auto fit = misfit(pieces, ends[i], ends[j], ends.size() == 2);
        if (fit) pairs.push_back({*fit, ends[i], ends[j]});
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return x.misfit < y.misfit; });
    for (const Pair& pair : pairs) {
      std::optional<End>& afterA = pieces[pair.a.piece].next[pair.a.end];
      std::optional<End>& afterB = pieces[pair.b.piece].next[pair.b.end];
      if (afterA || afterB) continue;
      afterA = pair.b;
      afterB = pair.a;
    }
  }
}

// Joins the pieces that continue each other, beginning at the end `from` of a piece.
MapRoad follow(const std::vector<Piece>& pieces, const End& from, std::vector<bool>& used) {
  MapRoad whole;
  double longest = 0;
  for (std::optional<End> at = from; at && !used[at->piece]; at = pieces[at->piece].next[1 - at->end]) {
    used[at->piece] = true;
    MapRoad part = pieces[at->piece].road;
    if (at->end == 1) {
      std::reverse(part.line.begin(), part.line.end());
      std::reverse(part.nodes.begin(), part.nodes.end());
    }
    // All properties except the line and its nodes come from the longest piece.
    std::vector<Point2> line = std::move(whole.line);
    std::vector<std::int64_t> nodes = std::move(whole.nodes);
    const std::size_t skip = line.empty() ? 0 : 1;
    line.insert(line.end(), part.line.begin() + static_cast<std::ptrdiff_t>(skip), part.line.end());
    nodes.insert(nodes.end(), part.nodes.begin() + static_cast<std::ptrdiff_t>(skip), part.nodes.end());
    if (part.length() > longest) {
      longest = part.length();
      whole = part;
    }
    whole.line = std::move(line);
    whole.nodes = std::move(nodes);
  }
  return whole;
}

}  // namespace

std::vector<MapRoad> joinRoads(const std::vector<MapRoad>& roads) {
  std::vector<Piece> pieces = cut(roads);
  match(pieces);
  std::vector<bool> used(pieces.size(), false);
  std::vector<MapRoad> joined;
  const auto begin = [&](bool loops) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (used[i]) continue;
      // One-way roads are followed only from their start.
      if (loops || !pieces[i].next[0]) {
        joined.push_back(follow(pieces, {i, 0}, used));
      } else if (!pieces[i].next[1] && !pieces[i].road.oneWay) {
        joined.push_back(follow(pieces, {i, 1}, used));
      }
    }
  };
  begin(false);
  begin(true);
  return joined;
}

}  // namespace scanmill::town
