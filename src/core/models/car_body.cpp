// Lofts a car's body: cross sections along x follow the side profile (bonnet, windscreen, roof, rear) and leave the
// wheel arches open. The position along x and around the cross section determines the material.

#include <algorithm>
#include <cmath>

#include "models/facade.h"

namespace scanmill::models {
namespace {

// Rounds a line's corners. Each pass cuts off each corner at a fifth of both sides; the line's ends stay. Chaikin, "An
// algorithm for high-speed curve generation", Computer Graphics and Image Processing 3 (1974), with other ratios.
std::vector<Point2> rounded(std::vector<Point2> line, int passes) {
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<Point2> finer{line.front()};
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      if (i > 0) finer.push_back(lerp(line[i], line[i + 1], 0.2));
      if (i + 2 < line.size()) finer.push_back(lerp(line[i], line[i + 1], 0.8));
    }
    finer.push_back(line.back());
    line = std::move(finer);
  }
  return line;
}

class BodyMaker {
 public:
  BodyMaker(Shape& shape, const BodyForm& form)
      : s_(shape),
        f_(form),
        paint_(s_.surface(f_.className, f_.paint)),
        glass_(s_.surface(f_.className, "glass")),
        black_(s_.surface(f_.className, "plastic_black")),
        reflector_(s_.surface(f_.className, "sign_retroreflective")),
        top_(rounded(f_.profile, 2)) {
    for (const Point2& p : f_.profile) roof_ = std::max(roof_, p.y);
  }

  void make() {
    body();
    for (const double x : f_.axles) {
      const double y = f_.width / 2 - f_.wheelWidth / 2 - 0.015;
      appendWheels(s_, f_.className, x, y, f_.wheelRadius, f_.wheelWidth);
    }
    trim();
  }

  // Returns the height (m) of the body's upper edge in the side view at `x` (m, forward from the body's middle).
  double topAt(double x) const {
    for (std::size_t i = 0; i + 1 < top_.size(); ++i) {
      if (x <= top_[i + 1].x) {
        const double run = top_[i + 1].x - top_[i].x;
        return run > 1e-9 ? lerp(top_[i].y, top_[i + 1].y, std::max(0.0, (x - top_[i].x) / run)) : top_[i + 1].y;
      }
    }
    return top_.back().y;
  }

 private:
  // Number of points of a section(), from mid-floor to mid-roof. Segment k is between the points k and k + 1.
  static constexpr int kPoints = 15;
  static constexpr double kArchRadius = 1.16;  // radius of a wheel arch divided by the radius of the wheel

  double halfWidth(double x) const {
    const double end = f_.length / 2;
    const double nose = std::clamp((x - end + 0.8) / 0.8, 0.0, 1.0);
    const double tail = std::clamp((-x - end + 0.7) / 0.7, 0.0, 1.0);
    return f_.width / 2 * (1 - f_.noseTaper * nose * nose * nose - f_.tailTaper * tail * tail * tail);
  }

  // Returns the height (m) of the lower edge of the body's sides, which rises at both ends and over the wheels.
  double sill(double x) const {
    const double rise = smooth((std::abs(x) - f_.length / 2 + 0.6) / 0.6) * 0.06;
    double z = f_.floor + 0.05 + rise;
    const double arch = f_.wheelRadius * kArchRadius;
    for (const double axle : f_.axles) {
      const double d = std::abs(x - axle);
      if (d < arch) z = std::max(z, f_.wheelRadius + std::sqrt(arch * arch - d * d));
    }
    return z;
  }

  // Returns the left half of a cross section: kPoints points from mid-floor over the side to mid-roof. Ratios by eye.
  std::vector<Vec3d> section(double x) const {
    const double half = halfWidth(x);
    const double low = sill(x);
    const double top = topAt(x);
    constexpr double kLeastAbove = 0.07;  // m, least height of the body above the belt
    constexpr double kBonnet = 0.1;       // m, height above the belt up to which the body has no cabin
    const double belt = std::min(f_.belt - f_.beltRise * x, top - kLeastAbove);  // lower edge of the windows
    // `cabin` is 0 at the bonnet and at the boot, 1 where the roof is highest.
    const double cabin = std::clamp((top - belt - kBonnet) / (roof_ - f_.belt - kBonnet), 0.0, 1.0);
    const double shoulder = half * 0.955;  // half of the width at the belt
    const double taper = half / (f_.width / 2);
    const double roofEdge = lerp(shoulder * 0.86, f_.roofHalf * taper, cabin);       // half of the width of the top
    const double well = std::min(f_.width / 2 - f_.wheelWidth - 0.08, half - 0.12);  // inner side of the wheels
    const double crown = lerp(0.03, 0.05, cabin);  // m, rise from the roof's edge to its middle
    std::vector<Vec3d> p{
        {x, 0, f_.floor},  // floor and wheel wells; surfaceAt() depends on the order of the points
        {x, well, f_.floor},
        {x, well, low},
        {x, half * 0.965, low},  // side below the windows
        {x, half * 0.988, lerp(low, belt, 0.22)},
        {x, half, lerp(low, belt, 0.5)},
        {x, half * 0.996, lerp(low, belt, 0.72)},
        {x, half * 0.98, lerp(low, belt, 0.9)},
        {x, shoulder, belt},  // windows
        {x, lerp(shoulder, roofEdge, 0.12), lerp(belt, top - crown, 0.08)},
        {x, lerp(shoulder, roofEdge, 0.55), lerp(belt, top - crown, 0.5)},
        {x, lerp(shoulder, roofEdge, 0.92), lerp(belt, top - crown, 0.9)},
        {x, roofEdge * 0.96, top - crown * 0.75},  // roof or bonnet
        {x, roofEdge * 0.6, top - crown * 0.2},
        {x, 0, top},
    };
    // Bumpers: the front and the rear protrude at heights around 0.5 m.
    const double end = std::clamp((std::abs(x) - f_.length / 2 + 0.3) / 0.3, 0.0, 1.0);
    for (Vec3d& v : p) v.x += std::copysign(end * bulgeAt(v.y, v.z, half), x);
    return p;
  }

  // Returns the sorted positions x (m) of the cross sections: 9 mm apart or more, dense at bumpers, arches and windows.
  std::vector<double> stations() const {
    const double end = f_.length / 2;
    std::vector<double> xs{-end, -end + 0.06, -end + 0.15, -end + 0.28, end - 0.28, end - 0.15, end - 0.06, end};
    for (const Point2& p : top_) xs.push_back(p.x);
    std::vector<Span> spans = f_.sideWindows;
    spans.insert(spans.end(), {f_.windscreen, f_.rearWindow, f_.bed});
    for (const Span& s : spans) xs.insert(xs.end(), {s.low, s.high});
    const double arch = f_.wheelRadius * kArchRadius;
    constexpr int kArchSections = 9;
    for (const double axle : f_.axles) {
      for (int k = 0; k <= kArchSections; ++k) xs.push_back(axle + arch * 0.999 * std::cos(kPi * k / kArchSections));
      xs.insert(xs.end(), {axle - arch - 0.012, axle + arch + 0.012});
    }
    std::sort(xs.begin(), xs.end());
    constexpr double kLeastDistance = 0.009;  // m
    std::vector<double> apart{-end};
    for (const double x : xs) {
      if (x > apart.back() + kLeastDistance && x < end - kLeastDistance) apart.push_back(x);
    }
    apart.push_back(end);
    return apart;
  }

  // Returns the surface of a segment of the cross section. Segments: 0 to 2 floor and wheel wells, 3 sill, 4 to 8 side
  // below the windows, 9 to 11 windows and their frame, 12 and 13 roof or bonnet.
  SurfaceIndex surfaceAt(double x, int segment) const {
    if (segment < 3) return black_;
    if (segment == 3) return f_.floor > 0.28 ? paint_ : black_;
    const auto within = [&](const Span& s) { return x > s.low && x < s.high; };
    const bool side = segment == 9 || segment == 10;
    const bool top = segment == 12 || segment == 13;
    if (side && std::any_of(f_.sideWindows.begin(), f_.sideWindows.end(), within)) return glass_;
    if ((top || segment == 11) && (within(f_.windscreen) || within(f_.rearWindow))) return glass_;
    if (top && within(f_.bed)) return black_;
    return paint_;
  }

  // Adds the left half of the body, its mirror image, and the ends.
  void body() {
    const std::vector<double> xs = stations();
    std::vector<std::vector<Vec3d>> left;
    std::vector<std::vector<Vec3d>> right;
    for (const double x : xs) {
      left.push_back(section(x));
      right.push_back(left.back());
      for (Vec3d& v : right.back()) v.y = -v.y;
      std::reverse(right.back().begin(), right.back().end());
    }
    const auto middle = [&](int row) {
      const auto r = static_cast<std::size_t>(row);
      return (xs[r] + xs[r + 1]) / 2;
    };
    s_.grid(right, Loop::Open, [&](int row, int c) { return surfaceAt(middle(row), kPoints - 2 - c); });
    s_.grid(left, Loop::Open, [&](int row, int c) { return surfaceAt(middle(row), c); });
    cap(left.front(), true);
    cap(left.back(), false);
  }

  // Returns how far a bumper protrudes (m) at `y` and `z` (m): most at the height 0.48 m, less at the sides.
  double bulgeAt(double y, double z, double width) const {
    const double height = (z - 0.48) / 0.42;
    return f_.bulge * std::max(0.0, 1 - height * height) * (1 - 0.5 * std::pow(std::abs(y) / width, 4.0));
  }

  // Closes the body's front or rear end. `half`: the left half of the cross section at this end.
  void cap(const std::vector<Vec3d>& half, bool rear) {
    constexpr int kAcross = 8;
    const double end = rear ? -f_.length / 2 : f_.length / 2;
    const double width = halfWidth(end);
    std::vector<std::vector<Vec3d>> rows;
    for (std::size_t i = 1; i < half.size(); ++i) {
      if (i == 2) continue;  // point 2 is as high as point 3
      std::vector<Vec3d> row;
      for (int c = 0; c <= kAcross; ++c) {
        const double y = lerp(half[i].y, -half[i].y, double(c) / kAcross) * (rear ? 1 : -1);
        row.push_back({end + std::copysign(bulgeAt(y, half[i].z, width), end), y, half[i].z});
      }
      rows.push_back(std::move(row));
    }
    s_.grid(rows, Loop::Open, [&](int row, int) { return row < 1 ? black_ : paint_; });
  }

  // Adds number plates, grille and lights and, if `mirrors` is set, mirrors and door handles.
  void trim() {
    const double end = f_.length / 2;
    const double nose = std::min(topAt(end - 0.05), 0.95);
    const auto tip = [&](double z) { return end + bulgeAt(0, z, 1); };  // x of the bumper at a height
    const double plate = std::min(0.75, f_.belt - 0.2);
    s_.box(reflector_, {tip(0.42), 0, 0.42}, {0.03, 0.52, 0.11});
    s_.box(reflector_, {-tip(plate), 0, plate}, {0.05, 0.52, 0.11});
    s_.box(black_, {tip(0.58) - 0.005, 0, 0.58}, {0.05, f_.width * 0.42, 0.1});
    for (const double side : {-1.0, 1.0}) {
      s_.ball(glass_, {end - 0.13, side * halfWidth(end - 0.13) * 0.8, nose - 0.06}, {0.17, 0.17, 0.075}, 12);
      s_.ball(reflector_, {-end + 0.07, side * halfWidth(-end + 0.07) * 0.86, std::min(f_.belt - 0.08, 0.95)},
              {0.1, 0.1, 0.13}, 10);
      if (f_.mirrors) {
        const double x = f_.sideWindows.back().high - 0.05;
        const double y = f_.width / 2;
        s_.box(black_, {x, side * (y - 0.02), f_.belt + 0.04}, {0.08, 0.1, 0.04});
        s_.ball(paint_, {x, side * (y + 0.045), f_.belt + 0.09}, {0.07, 0.1, 0.075}, 10);
        for (const Span& window : f_.sideWindows) {
          const double handle = window.low + 0.12;
          s_.box(black_, {handle, side * (y * 0.985), f_.belt - f_.beltRise * handle - 0.1}, {0.17, 0.045, 0.03});
        }
      }
    }
  }

  Shape& s_;
  const BodyForm& f_;
  SurfaceIndex paint_, glass_, black_, reflector_;
  std::vector<Point2> top_;
  double roof_ = 0;
};

}  // namespace

void appendBody(Shape& shape, const BodyForm& form) {
  BodyMaker(shape, form).make();
}

void appendWheel(Shape& shape, std::string_view className, const Affine& pose, double radius, double width) {
  const auto [rubber, rim, dark] = shape.surfaces(className, "rubber", "metal_bare", "plastic_black");
  // Turns z, about which the profile rotates, to +y, the outward direction of the axle.
  const Affine axle = pose * Affine{{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {}};
  const double w = width / 2;
  const double inner = radius * 0.64;  // m, radius where the tyre ends and the rim begins
  const std::vector<Point2> tyre{{inner, -w * 0.9},       {radius * 0.93, -w},     {radius, -w * 0.7},
                                 {radius, w * 0.7},       {radius * 0.93, w},      {inner, w * 0.9},
                                 {inner - 0.01, w * 0.7}, {inner - 0.01, -w * 0.7}};
  shape.revolve(rubber, axle, tyre, 28, Loop::Closed);
  shape.revolve(dark, axle, {{0, -w * 0.6}, {inner, -w * 0.6}, {inner, w * 0.2}, {0, w * 0.2}}, 20);  // brake drum
  shape.revolve(rim, axle, {{inner - 0.022, w * 0.25}, {inner, w * 0.4}, {inner, w * 0.82}, {inner - 0.022, w * 0.8}},
                28, Loop::Closed);
  shape.revolve(rim, axle, {{radius * 0.16, w * 0.1}, {radius * 0.16, w * 0.62}, {0, w * 0.66}}, 12);  // hub
  constexpr int kSpokes = 7;
  for (const Point2& p : regularPolygon(kSpokes, 1)) {
    const Vec3d out{p.x, p.y, 0};
    const Affine spoke{{out, {-out.y, out.x, 0}, {0, 0, 1}}, out * (radius * 0.38) + Vec3d{0, 0, w * 0.5}};
    shape.boxAt(rim, axle * spoke, {radius * 0.5, radius * 0.11, w * 0.2});
  }
}

void appendWheels(Shape& shape, std::string_view className, double x, double y, double radius, double width) {
  appendWheel(shape, className, at({x, y, radius}), radius, width);
  appendWheel(shape, className, at({x, -y, radius}, kPi), radius, width);
}

}  // namespace scanmill::models
