// Builds walls with windows and doors, and the details of houses.

#include "models/facade.h"

#include <algorithm>
#include <cmath>

namespace scanmill::models {
namespace {

class FacadeMaker {
 public:
  FacadeMaker(Shape& shape, const FacadeLook& look, Draw& draw) : s_(shape), look_(look), draw_(draw) {}

  // Divides the wall into rectangles along the edges of all openings. Adds the rectangles that are in no opening, then
  // the openings. Coordinates (m): u along the wall, v upwards, w outwards.
  void make(double width, const std::vector<Opening>& openings) {
    std::vector<double> us{0, width};
    std::vector<double> vs{look_.foundation, look_.top};
    for (const Opening& o : openings) {
      us.insert(us.end(), {o.u.low, o.u.high});
      vs.insert(vs.end(), {o.v.low, o.v.high});
    }
    for (std::vector<double>* lines : {&us, &vs}) {
      std::sort(lines->begin(), lines->end());
      lines->erase(std::unique(lines->begin(), lines->end(), [](double a, double b) { return b - a < 1e-6; }),
                   lines->end());
    }
    for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
      for (std::size_t i = 0; i + 1 < us.size(); ++i) {
        const double u = (us[i] + us[i + 1]) / 2;
        const double v = (vs[j] + vs[j + 1]) / 2;
        if (std::ranges::any_of(openings, [&](const Opening& o) { return o.u.holds(u) && o.v.holds(v); })) continue;
        s_.quad(look_.wall, {us[i], vs[j], 0}, {us[i + 1], vs[j], 0}, {us[i + 1], vs[j + 1], 0}, {us[i], vs[j + 1], 0});
      }
    }
    for (const Opening& o : openings) {
      reveal(o);
      o.what == Opening::Window ? window(o) : door(o);
    }
  }

 private:
  // Adds the four faces between the wall's surface and the recessed window or door.
  void reveal(const Opening& o) {
    const double w = -kReveal;
    const auto [u0, u1] = o.u;
    const auto [v0, v1] = o.v;
    s_.quad(look_.trim, {u0, v0, 0}, {u1, v0, 0}, {u1, v0, w}, {u0, v0, w});
    s_.quad(look_.trim, {u1, v1, 0}, {u0, v1, 0}, {u0, v1, w}, {u1, v1, w});
    s_.quad(look_.trim, {u0, v1, 0}, {u0, v0, 0}, {u0, v0, w}, {u0, v1, w});
    s_.quad(look_.trim, {u1, v0, 0}, {u1, v1, 0}, {u1, v1, w}, {u1, v0, w});
  }

  // Adds a window's glass and its casing with bars. A window up to 2 m high also gets a sill and, by `look_`, shutters.
  void window(const Opening& o) {
    const auto [u0, u1] = o.u;
    const auto [v0, v1] = o.v;
    constexpr double kFrame = 0.07;  // m, width of the casing
    const double w = -kReveal;
    s_.quad(look_.glass, {u0, v0, w}, {u1, v0, w}, {u1, v1, w}, {u0, v1, w});
    // The casing extends a few millimetres into the wall and behind the glass, so that no two faces are coplanar.
    const double middleU = (u0 + u1) / 2;
    const double middleV = (v0 + v1) / 2;
    const double innerHeight = v1 - v0 - kFrame * 2;
    for (const double u : {u0 + kFrame / 2 - 0.005, u1 - kFrame / 2 + 0.005}) {
      s_.box(look_.casing, {u, middleV, w + 0.02}, {kFrame + 0.01, v1 - v0 + 0.02, 0.06});
    }
    for (const double v : {v0 + kFrame / 2 - 0.004, v1 - kFrame / 2 + 0.004}) {
      s_.box(look_.casing, {middleU, v, w + 0.019}, {u1 - u0 - kFrame, kFrame + 0.008, 0.058});
    }
    const int panes = u1 - u0 > 1.8 ? static_cast<int>((u1 - u0) / 0.9) : 2;
    for (int k = 1; k < panes; ++k) {
      s_.box(look_.casing, {lerp(u0, u1, double(k) / panes), middleV, w + 0.015}, {0.05, innerHeight, 0.05});
    }
    const bool shopWindow = v1 - v0 > 2;
    if (!draw_.chance(shopWindow ? 0.25 : 0.1)) curtain(o);
    if (!shopWindow) {
      s_.box(look_.casing, {middleU, v1 - (v1 - v0) * 0.3, w + 0.013}, {u1 - u0 - kFrame * 2, 0.04, 0.046});
      s_.box(look_.trim, {middleU, v0 - 0.02, -0.035}, {u1 - u0 + 0.12, 0.05, 0.19});
    }
    if (look_.shutters && !shopWindow) {
      const double shutterWidth = (u1 - u0) / 2;
      for (const double u : {u0 - shutterWidth / 2 - 0.02, u1 + shutterWidth / 2 + 0.02}) {
        s_.box(look_.wood, {u, middleV, 0.01}, {shutterWidth, v1 - v0, 0.06});
      }
    }
  }

  // Adds a curtain or a lowered blind behind a window.
  void curtain(const Opening& o) {
    constexpr int kFolds = 6;
    constexpr double kBehindGlass = 0.08, kFoldDepth = 0.05;  // m
    const double low = lerp(o.v.low, o.v.high, draw_.chance(0.2) ? draw_.in(0, 0.4) : -0.05);
    const auto fold = [&](int k, double v) {
      return Vec3d{lerp(o.u.low, o.u.high, k / double(kFolds)), v, -kReveal - kBehindGlass - kFoldDepth * (k % 2)};
    };
    for (int k = 0; k < kFolds; ++k) {
      s_.quad(look_.cloth, fold(k, low), fold(k + 1, low), fold(k + 1, o.v.high), fold(k, o.v.high));
    }
  }

  // Adds a door leaf with panels, a pane and a handle, steps from the door down to the path, and a small roof.
  void door(const Opening& o) {
    const auto [u0, u1] = o.u;
    const auto [v0, v1] = o.v;
    const double w = -kReveal;
    const double middle = (u0 + u1) / 2;
    s_.quad(look_.wood, {u0, v0, w}, {u1, v0, w}, {u1, v1, w}, {u0, v1, w});
    for (const double v : {v0 + 0.45, v0 + 1.1}) s_.box(look_.wood, {middle, v, w}, {u1 - u0 - 0.35, 0.45, 0.05});
    s_.quad(look_.glass, {u0 + 0.2, v1 - 0.5, w + 0.02}, {u1 - 0.2, v1 - 0.5, w + 0.02},
            {u1 - 0.2, v1 - 0.15, w + 0.02}, {u0 + 0.2, v1 - 0.15, w + 0.02});
    s_.rod(look_.metal, {u1 - 0.12, v0 + 1.0, w + 0.05}, {u1 - 0.12, v0 + 1.15, w + 0.05}, 0.015, 6);
    const int steps = std::max(1, static_cast<int>(std::ceil(v0 / 0.17)));
    for (int k = 0; k < steps; ++k) {
      const double top = v0 - 0.01 - k * v0 / steps;
      const double out = 0.55 + 0.28 * k;
      s_.box(look_.trim, {middle, (top + look_.foundation) / 2, out / 2 - 0.05},
             {1.5 + 0.02 * k, top - look_.foundation, out});
    }
    s_.box(look_.tile, {middle, v1 + 0.25, 0.4}, {1.7, 0.08, 0.9});
  }

  Shape& s_;
  const FacadeLook& look_;
  Draw& draw_;
};

}  // namespace

FacadeLook facadeLook(Shape& shape, const char* wall, Draw& draw) {
  const char* const casing = draw.chance(0.5) ? "wood" : "painted_metal";
  const char* const pane = draw.chance(0.7) ? "glass_coated" : "glass";
  return {.wall = shape.surface("building", wall),
          .trim = shape.surface("building", "concrete"),
          .wood = shape.surface("building", "wood"),
          .metal = shape.surface("building", "painted_metal"),
          .tile = shape.surface("building", "roof_tile"),
          .glass = shape.surface("window", pane),
          .casing = shape.surface("window", casing),
          .cloth = shape.surface("window", "cloth")};
}

void addFacade(Shape& shape, const FacadeLook& look, const Affine& wallFrame, double width,
               const std::vector<Opening>& openings, Draw& draw) {
  const Affine outer = shape.frame;
  shape.frame = outer * wallFrame;
  FacadeMaker(shape, look, draw).make(width, openings);
  shape.frame = outer;
}

}  // namespace scanmill::models
