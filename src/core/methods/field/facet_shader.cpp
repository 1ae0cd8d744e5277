#include "methods/field/facet_shader.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

#include "methods/field/distance_field.h"

namespace scanmill {

namespace {

// In the order of facetOf() and Facet::distance2().
constexpr const char* kFacet = R"(
double dotted(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

dvec3 crossed(dvec3 a, dvec3 b) {
  precise dvec3 product = dvec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return product;
}

// The error of a rounded product (T. J. Dekker, "A floating-point technique for extending the available precision",
// 1971).
double productError(double a, double b, double product) {
  precise double bigA = 134217729.0LF * a;
  precise double highA = bigA - (bigA - a);
  precise double lowA = a - highA;
  precise double bigB = 134217729.0LF * b;
  precise double highB = bigB - (bigB - b);
  precise double lowB = b - highB;
  precise double error = ((highA * highB - product) + highA * lowB + lowA * highB) + lowA * lowB;
  return error;
}

// The numbers next to one.
void neighbours(double x, out double below, out double above) {
  precise double half_ = 1.1102230246251568e-16LF * x;
  precise double less = x - half_;
  precise double more = x + half_;
  below = less;
  above = more;
}

// Both rounded correctly: one step of Newton's from a number that is off by a few units, and then the neighbour where
// that is nearer; what is left of x is exact.
double rootOf(double x, double about) {
  precise double square = about * about;
  precise double off = (x - square) - productError(about, about, square);
  precise double root = about + off / (2.0LF * about);
  double below, above;
  neighbours(root, below, above);
  precise double product = root * root;
  precise double left = (x - product) - productError(root, root, product);
  precise double upwards = root * (above - root);
  precise double downwards = -(root * (root - below));
  return left > upwards ? above : left <= downwards ? below : root;
}

double inverseOf(double x, double about) {
  precise double one = about * x;
  precise double off = (1.0LF - one) - productError(about, x, one);
  precise double inverse = about + off * about;
  double below, above;
  neighbours(inverse, below, above);
  precise double product = inverse * x;
  precise double left = 2.0LF * ((1.0LF - product) - productError(inverse, x, product));
  precise double upwards = x * (above - inverse);
  precise double downwards = -(x * (inverse - below));
  return left > upwards ? above : left < downwards ? below : inverse;
}

// Rounded once more it is still the correct one.
float rootOf(float x) {
  return x == 0.0 ? 0.0 : float(rootOf(double(x), sqrt(double(x))));
}

// 1 / length, of a squared length; 0 where there is none.
double scaleOf(double square, inout bool sure) {
  if (square == 0.0LF) return 0.0LF;
  if (square < 1e-200LF) sure = false;
  double root = rootOf(square, sqrt(square));
  return inverseOf(root, 1.0LF / root);
}

float dotted(vec3 a, vec3 b) {
  precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

// A device may take it for nothing once it is squared.
bool tiny(float x) {
  return x != 0.0 && abs(x) < 1e-18;
}

struct EdgePlace {
  float within, square, excess;
};

EdgePlace placeAt(dvec3 normal, dvec3 along, dvec3 from, dvec3 to, vec3 point) {
  dvec3 inward = crossed(normal, along);
  float inside = float(-dotted(inward, from));
  float before = float(dotted(along, from));
  float past = float(-dotted(along, to));
  precise float within = dotted(vec3(inward), point) + inside;
  float way = dotted(vec3(along), point);
  precise float less = before - way;
  precise float more = way + past;
  precise float excess = max(max(less, more), 0.0);
  precise float square = within * within + excess * excess;
  return EdgePlace(within, square, excess);
}

float distance2To(dvec3 a, dvec3 b, dvec3 c, vec3 point, inout bool sure) {
  precise dvec3 ab = b - a;
  precise dvec3 bc = c - b;
  precise dvec3 ca = a - c;
  double ab2 = dotted(ab, ab);
  double bc2 = dotted(bc, bc);
  double ca2 = dotted(ca, ca);
  double most = max(ab2, max(bc2, ca2));
  if (ab2 < most) {  // the longest edge comes first
    dvec3 first = a;
    if (bc2 >= ca2) {
      a = b;
      b = c;
      c = first;
    } else {
      a = c;
      c = b;
      b = first;
    }
  }
  precise dvec3 side0 = b - a;
  precise dvec3 side1 = c - b;
  precise dvec3 side2 = a - c;
  dvec3 normal = crossed(side0, -side2);
  double area2 = dotted(normal, normal);
  precise double least2 = 1e-20LF * most * most;
  double scale1 = scaleOf(dotted(side1, side1), sure);
  double scale2 = scaleOf(dotted(side2, side2), sure);
  precise dvec3 along0 = side0 * scaleOf(most, sure);
  if (most == 0.0LF) along0 = dvec3(1.0LF, 0.0LF, 0.0LF);
  if (!(area2 > least2)) {  // a line: any normal does
    normal = crossed(along0, abs(along0.x) < 0.7LF ? dvec3(1.0LF, 0.0LF, 0.0LF) : dvec3(0.0LF, 1.0LF, 0.0LF));
    area2 = dotted(normal, normal);
  }
  precise dvec3 unit = normal * scaleOf(area2, sure);
  precise dvec3 along1 = side1 * scale1;
  precise dvec3 along2 = side2 * scale2;
  if (scale1 == 0.0LF) along1 = along0;
  if (scale2 == 0.0LF) along2 = along0;
  float height = float(-dotted(unit, a));
  precise float up = dotted(vec3(unit), point) + height;
  EdgePlace e0 = placeAt(unit, along0, a, b, point);
  EdgePlace e1 = placeAt(unit, along1, b, c, point);
  EdgePlace e2 = placeAt(unit, along2, c, a, point);
  bool above = min(min(e0.within, e1.within), min(e2.within, -e0.excess)) >= 0.0;
  precise float distance2 = up * up + (above ? 0.0 : min(min(e0.square, e1.square), e2.square));
  if (tiny(up) || tiny(e0.within) || tiny(e1.within) || tiny(e2.within) || tiny(e0.excess) || tiny(e1.excess) ||
      tiny(e2.excess)) {
    sure = false;
  }
  return distance2;
}
)";

// In the order of cubeTestOf() and CubeTest::excess().
constexpr const char* kCube = R"(
float beyond(float value, float least, float most) {
  precise float below = least - value;
  precise float above = value - most;
  return max(below, above);
}

float beyondAxis(double u, double v, double edge, double tip, float along, float across) {
  precise double around = kListedHalf * (abs(u) + abs(v));
  precise double low = min(edge, tip) - around;
  precise double high = max(edge, tip) + around;
  precise float value = float(u) * along + float(v) * across;
  return beyond(value, float(low), float(high));
}

// Of axis k of the world and the edge from p to q, r being the third corner: all by their components k + 1 and k + 2.
float beyondEdge(dvec2 p, dvec2 q, dvec2 r, vec2 at) {
  precise double u = p.y - q.y;
  precise double v = q.x - p.x;
  precise double edge = u * p.x + v * p.y;
  precise double tip = u * r.x + v * r.y;
  return beyondAxis(u, v, edge, tip, at.x, at.y);
}

float beyondEdges(dvec2 a, dvec2 b, dvec2 c, vec2 at) {
  return max(beyondEdge(a, b, c, at), max(beyondEdge(b, c, a, at), beyondEdge(c, a, b, at)));
}

bool meetsCube(dvec3 a, dvec3 b, dvec3 c, vec3 point) {
  precise dvec3 least = min(min(a, b), c) - kListedHalf;
  precise dvec3 most = max(max(a, b), c) + kListedHalf;
  precise dvec3 ab = b - a;
  precise dvec3 ac = c - a;
  precise dvec3 normal = dvec3(ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x);
  precise dvec3 heights = dvec3(normal.x * a.x + normal.y * a.y + normal.z * a.z,
                                normal.x * b.x + normal.y * b.y + normal.z * b.z,
                                normal.x * c.x + normal.y * c.y + normal.z * c.z);
  precise double around = kListedHalf * (abs(normal.x) + abs(normal.y) + abs(normal.z));
  precise double lowest = min(min(heights.x, heights.y), heights.z) - around;
  precise double highest = max(max(heights.x, heights.y), heights.z) + around;
  vec3 n = vec3(normal);
  precise float height = n.x * point.x + n.y * point.y + n.z * point.z;
  float worst = beyond(height, float(lowest), float(highest));
  for (int k = 0; k < 3; ++k) worst = max(worst, beyond(point[k], float(least[k]), float(most[k])));
  worst = max(worst, beyondEdges(a.yz, b.yz, c.yz, point.yz));
  worst = max(worst, beyondEdges(a.zx, b.zx, c.zx, point.zx));
  worst = max(worst, beyondEdges(a.xy, b.xy, c.xy, point.xy));
  return worst <= 0.0;
}
)";

}  // namespace

std::string facetShader() {
  return kFacet;
}

std::string cubeShader() {
  return fmt::format("#define kListedHalf double(uintBitsToFloat({}u))\n", std::bit_cast<std::uint32_t>(kListedHalf)) +
         kCube;
}

}  // namespace scanmill
