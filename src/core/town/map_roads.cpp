// Joins the short ways of a map into long roads, as a driver would follow them.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "town/geometry.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

constexpr double kSharpest = 2.4;  // rad, largest change of direction at a point within a joined road

// An end of a piece of a road. `end`: 0 for the start of the piece, 1 for its end.
struct End {
  std::size_t piece;
  int end;
};

struct Piece {
  MapRoad road;
  // The ends of other pieces that are joined to this piece's start and end. Not set: no piece is joined.
  std::optional<End> next[2];
};

// Returns the change of direction (rad, 0 to pi) at a road's point `i`, which must not be the first or the last.
double turnAt(const MapRoad& road, std::size_t i) {
  const Point2& a = road.line[i - 1];
  const Point2& b = road.line[i];
  const Point2& c = road.line[i + 1];
  return std::abs(wrapped(std::atan2(c.y - b.y, c.x - b.x) - std::atan2(b.y - a.y, b.x - a.x)));
}

// Cuts roads into pieces at nodes that occur more than once and at turns of more than kSharpest.
std::vector<Piece> cutIntoPieces(const std::vector<MapRoad>& roads) {
  std::map<std::int64_t, int> uses;  // by node
  for (const MapRoad& road : roads) {
    for (const std::int64_t node : road.nodes) ++uses[node];
  }
  std::vector<Piece> pieces;
  for (const MapRoad& road : roads) {
    MapRoad properties = road;  // without the points: a road may have thousands of pieces
    properties.line.clear();
    properties.nodes.clear();
    std::ptrdiff_t first = 0;  // indices of the first and the last point of a piece
    for (std::ptrdiff_t last = 1; last < std::ssize(road.line); ++last) {
      const auto i = static_cast<std::size_t>(last);
      if (i + 1 < road.line.size() && uses[road.nodes[i]] < 2 && turnAt(road, i) < kSharpest) continue;
      Piece& piece = pieces.emplace_back(Piece{properties, {}});
      piece.road.line.assign(road.line.begin() + first, road.line.begin() + last + 1);
      piece.road.nodes.assign(road.nodes.begin() + first, road.nodes.begin() + last + 1);
      first = last;
    }
  }
  return pieces;
}

// Returns the direction (rad) in which a road leaves its start (`end` 0) or its end (1), averaged over kReach metres.
double headingFrom(const MapRoad& road, int end) {
  constexpr double kReach = 12;  // m, length over which the direction is averaged
  const std::size_t count = road.line.size();
  const auto at = [&](std::size_t i) { return road.line[end == 0 ? i : count - 1 - i]; };
  const Point2 start = at(0);
  std::size_t i = 1;
  while (i + 1 < count && std::hypot(at(i).x - start.x, at(i).y - start.y) < kReach) ++i;
  return std::atan2(at(i).y - start.y, at(i).x - start.x);
}

// Returns the misfit of two pieces that meet at their ends `a` and `b`: the change of direction (rad) plus
// penalties; nullopt if they must not be joined. `alone`: true if no other piece ends at the same node.
std::optional<double> misfit(const std::vector<Piece>& pieces, const End& a, const End& b, bool alone) {
  constexpr double kSharpestCrossing = 0.8;             // rad, where other roads join or the name changes
  constexpr double kOtherName = 0.5, kClassStep = 0.3;  // penalties, by eye
  const MapRoad& p = pieces[a.piece].road;
  const MapRoad& q = pieces[b.piece].road;
  if (p.ring != q.ring || p.oneWay != q.oneWay) return std::nullopt;
  if (p.oneWay && a.end == b.end) return std::nullopt;
  const double difference = headingFrom(p, a.end) - headingFrom(q, b.end);
  const double turn = std::abs(kPi - std::abs(wrapped(difference)));
  const bool sameName = !p.name.empty() && p.name == q.name;
  const bool minor = p.kind >= RoadClass::Service;
  if (minor != (q.kind >= RoadClass::Service) && !sameName) return std::nullopt;
  // At a sharp corner, only roundabouts are joined, or roads of the same name and class where no third road ends.
  const bool corner = p.ring || (alone && p.kind == q.kind && p.name == q.name);
  if (turn > (corner ? kSharpest : kSharpestCrossing)) return std::nullopt;
  const int classSteps = std::abs(static_cast<int>(p.kind) - static_cast<int>(q.kind));
  return turn + (sameName ? 0 : kOtherName) + kClassStep * classSteps;
}

// Sets Piece::next. At each node, joins pairs of ends in the order of their misfit, the least first.
void joinEnds(std::vector<Piece>& pieces) {
  std::map<std::int64_t, std::vector<End>> endsByNode;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const MapRoad& road = pieces[i].road;
    endsByNode[road.nodes.front()].push_back({i, 0});
    endsByNode[road.nodes.back()].push_back({i, 1});
  }
  struct Pair {
    double misfit;
    End a, b;
  };
  constexpr std::size_t kMostEnds = 100;  // more than at any real junction; bounds the number of pairs
  for (const auto& [node, ends] : endsByNode) {
    if (ends.size() > kMostEnds) continue;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      for (std::size_t j = i + 1; j < ends.size(); ++j) {
        if (ends[i].piece == ends[j].piece && ends.size() > 2) continue;
        const auto fit = misfit(pieces, ends[i], ends[j], ends.size() == 2);
        if (fit) pairs.push_back({*fit, ends[i], ends[j]});
      }
    }
    std::ranges::stable_sort(pairs, {}, &Pair::misfit);
    for (const Pair& pair : pairs) {
      std::optional<End>& afterA = pieces[pair.a.piece].next[pair.a.end];
      std::optional<End>& afterB = pieces[pair.b.piece].next[pair.b.end];
      if (afterA || afterB) continue;
      afterA = pair.b;
      afterB = pair.a;
    }
  }
}

// Returns the road of all pieces joined from `start` on, with the longest piece's properties. Marks pieces as used.
MapRoad joinPieces(const std::vector<Piece>& pieces, const End& start, std::vector<bool>& used) {
  std::vector<Point2> line;
  std::vector<std::int64_t> nodes;
  MapRoad longest;
  for (std::optional<End> begin = start; begin && !used[begin->piece];
       begin = pieces[begin->piece].next[1 - begin->end]) {
    used[begin->piece] = true;
    MapRoad piece = pieces[begin->piece].road;
    if (begin->end == 1) {
      std::ranges::reverse(piece.line);
      std::ranges::reverse(piece.nodes);
    }
    const std::ptrdiff_t common = line.empty() ? 0 : 1;  // number of the piece's first points that `line` has already
    line.insert(line.end(), piece.line.begin() + common, piece.line.end());
    nodes.insert(nodes.end(), piece.nodes.begin() + common, piece.nodes.end());
    if (longest.line.empty() || piece.length() > longest.length()) longest = std::move(piece);
  }
  longest.line = std::move(line);
  longest.nodes = std::move(nodes);
  return longest;
}

}  // namespace

std::vector<MapRoad> joinRoads(const std::vector<MapRoad>& roads) {
  std::vector<Piece> pieces = cutIntoPieces(roads);
  joinEnds(pieces);
  std::vector<bool> used(pieces.size(), false);
  std::vector<MapRoad> joined;
  const auto joinFromEnds = [&](bool loops) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (used[i]) continue;
      // One-way roads are joined only from their start.
      if (loops || !pieces[i].next[0]) {
        joined.push_back(joinPieces(pieces, {i, 0}, used));
      } else if (!pieces[i].next[1] && !pieces[i].road.oneWay) {
        joined.push_back(joinPieces(pieces, {i, 1}, used));
      }
    }
  };
  joinFromEnds(false);
  joinFromEnds(true);
  return joined;
}

}  // namespace scanmill::town
