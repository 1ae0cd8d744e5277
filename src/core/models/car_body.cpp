// A body is lofted: cross-sections along x follow a side profile (bonnet, windscreen, roof, rear) and leave out the
// wheel arches. The position along x and around the cross-section determines the material.

#include <algorithm>
#include <cmath>

#include "models/facade.h"

namespace scanmill::models {
namespace {

// Rounds a profile by Chaikin's corner cutting, but keeps its ends.
std::vector<Point2> rounded(std::vector<Point2> line, int times) {
  for (; times > 0; --times) {
    std::vector<Point2> next{line.front()};
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Point2 a = line[i];
      const Point2 b = line[i + 1];
      if (i > 0) next.push_back(lerp(a, b, 0.2));
      if (i + 2 < line.size()) next.push_back(lerp(a, b, 0.8));
    }
    next.push_back(line.back());
    line = std::move(next);
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
  static constexpr int kPoints = 15;  // number of points of section(), from mid-floor to mid-roof

  double halfWidth(double x) const {
    const double end = f_.length / 2;
    const double nose = std::clamp((x - end + 0.8) / 0.8, 0.0, 1.0);
    const double tail = std::clamp((-x - end + 0.7) / 0.7, 0.0, 1.0);
    return f_.width / 2 * (1 - f_.noseTaper * nose * nose * nose - f_.tailTaper * tail * tail * tail);
  }

  double sill(double x) const {
    const double up = smooth((std::abs(x) - f_.length / 2 + 0.6) / 0.6) * 0.06;
    double z = f_.floor + 0.05 + up;
    const double arch = f_.wheelRadius * 1.16;
    for (const double axle : f_.axles) {
      const double d = std::abs(x - axle);
      if (d < arch) z = std::max(z, f_.wheelRadius + std::sqrt(arch * arch - d * d));
    }
    return z;
  }

  std::vector<Vec3d> section(double x) const {
    const double w = halfWidth(x);
    const double low = sill(x);
    const double t = topAt(x);
    const double b = std::min(f_.belt - f_.beltRise * x, t - 0.07);
    const double cabin = std::clamp((t - b - 0.1) / (roof_ - f_.belt - 0.1), 0.0, 1.0);
    const double shoulder = w * 0.955;
    const double narrow = w / (f_.width / 2);
    const double top = lerp(shoulder * 0.86, f_.roofHalf * narrow, cabin);
    const double well = std::min(f_.width / 2 - f_.wheelWidth - 0.08, w - 0.12);
    const double crown = lerp(0.03, 0.05, cabin);
    std::vector<Vec3d> p{
        {x, 0, f_.floor},
        {x, well, f_.floor},
        {x, well, low},
        {x, w * 0.965, low},
        {x, w * 0.988, lerp(low, b, 0.22)},
        {x, w, lerp(low, b, 0.5)},
        {x, w * 0.996, lerp(low, b, 0.72)},
        {x, w * 0.98, lerp(low, b, 0.9)},
        {x, shoulder, b},
        {x, lerp(shoulder, top, 0.12), lerp(b, t - crown, 0.08)},
        {x, lerp(shoulder, top, 0.55), lerp(b, t - crown, 0.5)},
        {x, lerp(shoulder, top, 0.92), lerp(b, t - crown, 0.9)},
        {x, top * 0.96, t - crown * 0.75},
        {x, top * 0.6, t - crown * 0.2},
        {x, 0, t},
    };
    // Bumpers: the front and the rear protrude at heights around 0.5 m.
    const double end = std::clamp((std::abs(x) - f_.length / 2 + 0.3) / 0.3, 0.0, 1.0);
    for (Vec3d& v : p) v.x += std::copysign(end * bulgeAt(v.y, v.z, w), x);
    return p;
  }

  std::vector<double> stations() const {
    const double end = f_.length / 2;
    std::vector<double> xs{-end, -end + 0.06, -end + 0.15, -end + 0.28, end - 0.28, end - 0.15, end - 0.06, end};
    for (const Point2& p : top_) xs.push_back(p.x);
    const auto ends = [&](const Span& s) {
      xs.push_back(s.low);
      xs.push_back(s.high);
    };
    ends(f_.windscreen);
    ends(f_.rearWindow);
    ends(f_.bed);
    for (const Span& s : f_.sideWindows) ends(s);
    const double arch = f_.wheelRadius * 1.16;
    constexpr int kArch = 9;
    for (const double axle : f_.axles) {
      for (int k = 0; k <= kArch; ++k) xs.push_back(axle + arch * 0.999 * std::cos(kPi * k / kArch));
      xs.push_back(axle - arch - 0.012);
      xs.push_back(axle + arch + 0.012);
    }
    std::sort(xs.begin(), xs.end());
    std::vector<double> kept{-end};
    for (const double x : xs) {
      if (x > kept.back() + 0.009 && x < end - 0.009) kept.push_back(x);
    }
    kept.push_back(end);
    return kept;
  }

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
    s_.grid(right, false, [&](int row, int c) { return surfaceAt(middle(row), kPoints - 2 - c); });
    s_.grid(left, false, [&](int row, int c) { return surfaceAt(middle(row), c); });
    cap(left.front(), true);
    cap(left.back(), false);
  }

  // Returns how far the bumpers protrude (m) at a height `z` and a distance `y` from the vehicle's middle plane: most
  // at z = 0.48 m, less towards the sides.
  double bulgeAt(double y, double z, double width) const {
    const double height = (z - 0.48) / 0.42;
    return f_.bulge * std::max(0.0, 1 - height * height) * (1 - 0.5 * std::pow(std::abs(y) / width, 4.0));
  }

  // Closes the front or the rear between the left and the right half of its cross-section; `half` is the left half.
  void cap(const std::vector<Vec3d>& half, bool rear) {
    constexpr int kAcross = 8;
    const double end = rear ? -f_.length / 2 : f_.length / 2;
    const double width = halfWidth(end);
    std::vector<std::vector<Vec3d>> rows;
    for (std::size_t i = 1; i < half.size(); ++i) {
      if (i == 2) continue;  // this point is as high as the next one
      std::vector<Vec3d> row;
      for (int c = 0; c <= kAcross; ++c) {
        const double y = lerp(half[i].y, -half[i].y, double(c) / kAcross) * (rear ? 1 : -1);
        row.push_back({end + std::copysign(bulgeAt(y, half[i].z, width), end), y, half[i].z});
      }
      rows.push_back(std::move(row));
    }
    s_.grid(rows, false, [&](int row, int) { return row < 1 ? black_ : paint_; });
  }

  void trim() {
    const double end = f_.length / 2;
    const double nose = std::min(topAt(end - 0.05), 0.95);
    // Adds number plates, grille and lights. Boxes are half sunk into the body.
    const auto tip = [&](double z) { return end + bulgeAt(0, z, 1); };
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

void appendWheel(Shape& shape, std::string_view className, const Affine& place, double radius, double width) {
  const SurfaceIndex rubber = shape.surface(className, "rubber");
  const SurfaceIndex rim = shape.surface(className, "metal_bare");
  const SurfaceIndex dark = shape.surface(className, "plastic_black");
  // The axle is along y: z of the profile becomes the outward direction of the axle.
  const Affine axle = place * Affine{{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {}};
  const double w = width / 2;
  const double inner = radius * 0.64;
  const std::vector<Point2> tyre{{inner, -w * 0.9},       {radius * 0.93, -w},     {radius, -w * 0.7},
                                 {radius, w * 0.7},       {radius * 0.93, w},      {inner, w * 0.9},
                                 {inner - 0.01, w * 0.7}, {inner - 0.01, -w * 0.7}};
  shape.revolve(rubber, axle, tyre, 28, true);
  shape.revolve(dark, axle, {{0, -w * 0.6}, {inner, -w * 0.6}, {inner, w * 0.2}, {0, w * 0.2}}, 20);
  shape.revolve(rim, axle, {{inner - 0.022, w * 0.25}, {inner, w * 0.4}, {inner, w * 0.82}, {inner - 0.022, w * 0.8}},
                28, true);
  shape.revolve(rim, axle, {{radius * 0.16, w * 0.1}, {radius * 0.16, w * 0.62}, {0, w * 0.66}}, 12);
  constexpr int kSpokes = 7;
  for (int k = 0; k < kSpokes; ++k) {
    const double angle = 2 * kPi * k / kSpokes;
    const Vec3d out{std::cos(angle), std::sin(angle), 0};
    const Affine spoke =
        axle * Affine{{out, {-out.y, out.x, 0}, {0, 0, 1}}, out * (radius * 0.38) + Vec3d{0, 0, w * 0.5}};
    shape.boxAt(rim, spoke, {radius * 0.5, radius * 0.11, w * 0.2});
  }
}

void appendWheels(Shape& shape, std::string_view className, double x, double y, double radius, double width) {
  appendWheel(shape, className, at({x, y, radius}), radius, width);
  appendWheel(shape, className, at({x, -y, radius}, kPi), radius, width);
}

}  // namespace scanmill::models
