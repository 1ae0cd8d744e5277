#include <bit>

#include "gpu/compute.h"
#include "methods/device/device_resolver.h"
#include "methods/device/device_tables.h"

namespace scanmill {

namespace {

constexpr const char* kDeclared = R"(
layout(std430, binding = 6) writeonly restrict buffer HitColumns { uint hitColumns[]; };
layout(binding = 0) uniform usamplerBuffer planeRecords;
layout(binding = 1) uniform usamplerBuffer stands;
layout(binding = 2) uniform usamplerBuffer materials;
layout(binding = 3) uniform usamplerBuffer texels;
layout(binding = 4) uniform usamplerBuffer texturedTriangles;

// The plane of a triangle, relative to the world's origin, and what the triangle says. A doubt is by how much the
// processor's number may differ.
struct Plane {
  dvec3 normal, normalDoubt;
  double offset, offsetDoubt;
  double along, alongDoubt;  // normal . direction of the ray
  uvec4 label;
  uint instance;
  uint place;
  double part;
};

double sum3(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

dvec3 across(dvec3 a, dvec3 b) {
  precise dvec3 product = dvec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return product;
}

double largest(dvec3 v) {
  dvec3 a = abs(v);
  return max(a.x, max(a.y, a.z));
}

dvec4 standRow(uint place, uint row) {
  int at = int(13u * place + 1u + 2u * row);
  uvec4 a = texelFetch(stands, at);
  uvec4 b = texelFetch(stands, at + 1);
  return dvec4(packDouble2x32(a.xy), packDouble2x32(a.zw), packDouble2x32(b.xy), packDouble2x32(b.zw));
}

// Row k of originFromMesh at a part of the revolution.
dvec4 placedRow(uint place, uint row, bool moving, double part) {
  precise dvec4 a = standRow(place, row);
  if (!moving) return a;
  dvec4 b = standRow(place, 3u + row);
  precise dvec4 between = a + (b - a) * part;
  return between;
}

void planeRecord(uint record, out dvec3 normal, out double offset) {
  uvec4 a = texelFetch(planeRecords, int(3u * record));
  uvec4 b = texelFetch(planeRecords, int(3u * record + 1u));
  normal = dvec3(packDouble2x32(a.xy), packDouble2x32(a.zw), packDouble2x32(b.xy));
  offset = packDouble2x32(b.zw);
}

Plane planeOf(uint triangle, uint place, float part, dvec3 o, dvec3 d) {
  uvec4 head = texelFetch(stands, int(13u * place));
  Plane p;
  planeRecord(head.x + triangle, p.normal, p.offset);
  p.normalDoubt = dvec3(0.0LF);
  p.offsetDoubt = 0.0LF;
  p.label = texelFetch(planeRecords, int(3u * (head.x + triangle) + 2u));
  p.instance = p.label.x;
  p.place = place;
  p.part = double(part);
  if (place != 0u) {
    bool moving = head.z == kMoving;
    dvec4 x = placedRow(place, 0u, moving, p.part);
    dvec4 y = placedRow(place, 1u, moving, p.part);
    dvec4 z = placedRow(place, 2u, moving, p.part);
    dvec3 translation = dvec3(x.w, y.w, z.w);
    dvec3 turned;
    // Of what moves, normals are turned by cofactors, and the processor divides these first by the determinant.
    double determinant = 1.0LF;
    double determinantBlur = 0.0LF;  // what its products add up to; likewise for each part of the normal
    dvec3 blur = dvec3(0.0LF);
    if (moving) {
      dvec3 columnX = dvec3(x.x, y.x, z.x);
      dvec3 columnY = dvec3(x.y, y.y, z.y);
      dvec3 columnZ = dvec3(x.z, y.z, z.z);
      dvec3 yz = across(columnY, columnZ);
      dvec3 zx = across(columnZ, columnX);
      dvec3 xy = across(columnX, columnY);
      determinant = sum3(columnX, yz);
      if (determinant < 0.0LF) {
        yz = -yz;
        zx = -zx;
        xy = -xy;
        determinant = -determinant;
      }
      precise dvec3 sum = yz * p.normal.x + zx * p.normal.y + xy * p.normal.z;
      turned = sum;
      dvec3 lx = abs(columnX), ly = abs(columnY), lz = abs(columnZ), n = abs(p.normal);
      blur = (ly.yzx * lz.zxy + ly.zxy * lz.yzx) * n.x + (lz.yzx * lx.zxy + lz.zxy * lx.yzx) * n.y +
             (lx.yzx * ly.zxy + lx.zxy * ly.yzx) * n.z;
      determinantBlur = sum3(lx, ly.yzx * lz.zxy + ly.zxy * lz.yzx);
    } else {
      turned = dvec3(sum3(standRow(place, 3u).xyz, p.normal), sum3(standRow(place, 4u).xyz, p.normal),
                     sum3(standRow(place, 5u).xyz, p.normal));
    }
    double scale = 1.0LF / sqrt(sum3(turned, turned));
    double blurred = (blur.x + blur.y + blur.z) * scale;  // share of the length
    p.normal = turned * scale;
    p.normalDoubt = (abs(p.normal) * (1.0LF + 4.0LF * blurred) + blur * (4.0LF * scale)) * kSlack;
    double shifted = p.offset * scale * determinant;
    double moved = sum3(p.normal, translation);
    p.offsetDoubt = sum3(p.normalDoubt, abs(translation)) +
                    (abs(shifted) * (1.0LF + 4.0LF * blurred) + abs(p.offset) * scale * determinantBlur * 4.0LF +
                     sum3(abs(p.normal), abs(translation))) * (2.0LF * kSlack);
    p.offset = shifted + moved;
    p.instance = p.label.x == 0u ? 0u : head.y + p.label.x - 1u;
  }
  p.along = sum3(p.normal, d);
  p.alongDoubt = sum3(p.normalDoubt, abs(d));
  if (place != 0u) p.alongDoubt += sum3(abs(p.normal), abs(d)) * kSlack;
  return p;
}

double distanceTo(Plane p, dvec3 o, out double doubt) {
  double origin = sum3(p.normal, o);
  double originDoubt = sum3(p.normalDoubt, abs(o));
  if (p.place != 0u) originDoubt += sum3(abs(p.normal), abs(o)) * kSlack;
  precise double gap = p.offset - origin;
  double range = gap / p.along;
  doubt = (p.offsetDoubt + originDoubt + abs(range) * p.alongDoubt) / max(abs(p.along) - p.alongDoubt, 1e-300LF) +
          abs(range) * kSlack;
  return range;
}

// Along a side of so many texels.
uint texelOf(float coordinate, uint side) {
  precise float part = coordinate - floor(coordinate);
  precise float place = part * float(side);
  return part > 0.0 ? min(uint(place), side - 1u) : 0u;
}

// Where the line of sight meets the triangle, in its texture. False where rounding could make it another texel.
bool texelAt(Plane p, double range, double doubt, dvec3 o, dvec3 d, uvec4 material, out uint texel) {
  int at = int(4u * (p.label.w - 1u));
  uvec4 behind = texelFetch(texturedTriangles, at + 3);
  uvec4 head = texelFetch(stands, int(13u * p.place));
  dvec3 corner[3];
  float u[3];
  for (int k = 0; k < 3; ++k) {
    uvec4 word = texelFetch(texturedTriangles, at + k);
    corner[k] = dvec3(uintBitsToFloat(word.xyz));
    u[k] = uintBitsToFloat(word.w);
  }
  if (p.place != 0u) {
    dvec4 rows[3];
    for (uint k = 0u; k < 3u; ++k) rows[k] = placedRow(p.place, k, head.z == kMoving, p.part);
    for (int k = 0; k < 3; ++k) {
      dvec3 c = corner[k];
      corner[k] = dvec3(sum3(rows[0].xyz, c) + rows[0].w, sum3(rows[1].xyz, c) + rows[1].w,
                        sum3(rows[2].xyz, c) + rows[2].w);
    }
  }
  dvec3 ab = corner[1] - corner[0];
  dvec3 ac = corner[2] - corner[0];
  dvec3 point = o + d * range - corner[0];
  dvec3 n = across(ab, ac);
  double square = sum3(n, n);
  double second = clamp(sum3(n, across(point, ac)) / square, 0.0LF, 1.0LF);
  double third = clamp(sum3(n, across(ab, point)) / square, 0.0LF, 1.0LF - second);
  double size = largest(corner[0]) + largest(corner[1]) + largest(corner[2]) + largest(o) + abs(range);
  double blur = (doubt + size * (8.0LF * kSlack)) * 16.0LF * (largest(ab) + largest(ac) + largest(point)) /
                sqrt(square);
  double first = 1.0LF - second - third;
  uvec2 sides = uvec2(material.z & 0xFFFFu, material.z >> 16);
  uvec2 index;
  bool sure = true;
  for (int k = 0; k < 2; ++k) {
    dvec3 v = dvec3(k == 0 ? vec3(u[0], u[1], u[2]) : uintBitsToFloat(behind.xyz));
    double value = first * v.x + second * v.y + third * v.z;
    double off = blur * (abs(v.y - v.x) + abs(v.z - v.x)) + (abs(v.x) + abs(v.y) + abs(v.z)) * (4.0LF * kSlack);
    // What lies between two coordinates of a repetition that are in one texel is in it, too.
    float low = float(value - off);
    float high = float(value + off);
    index[k] = texelOf(low, sides[k]);
    sure = floor(low) == floor(high) && index[k] == texelOf(high, sides[k]) && sure;
  }
  texel = texelFetch(texels, int(material.y + index.y * sides.x + index.x)).x;
  return sure;
}

// Whether the triangle's texture lets the ray pass; `sure` is false where rounding could decide it.
bool letsPass(Plane p, double range, double doubt, dvec3 o, dvec3 d, out bool sure) {
  sure = true;
  uvec4 material = texelFetch(materials, int(p.label.y >> 16));
  if ((material.w & kCutOut) == 0u) return false;
  uint texel;
  sure = texelAt(p, range, doubt, o, d, material, texel);
  return (texel & kLetsPass) != 0u;
}

bool wants(uint channel) {
  return (channels & channel) != 0u;
}

void leave(uint ray, uint verdict) {
  hitColumns[ray] = verdict;
}

void put(inout uint column, uint ray, uint word) {
  hitColumns[column + ray] = word;
  column += rays;
}

void miss(uint ray) {
  uint column = rays;
  int single = bitCount(channels & (kIncidence | kReflectance | kInstance | kPrimitive));
  if (wants(kSemantic | kMaterial)) ++single;
  for (int k = 0; k < single; ++k) put(column, ray, 0u);
  if (wants(kNormal)) {
    for (uint k = 0u; k < 3u; ++k) hitColumns[column + 3u * ray + k] = 0u;
  }
  hitColumns[ray] = kInfinite;
}
)";

constexpr const char* kHit = R"(
void hit(uint ray, Plane p, double range, double doubt, dvec3 o, dvec3 d) {
  float rounded;
  bool sure = settled(range, doubt, rounded);
  if (abs(range - nearest) <= doubt || abs(range - farthest) <= doubt || !(abs(p.along) > p.alongDoubt)) sure = false;
  if (sure && !(range >= nearest && range <= farthest)) {
    miss(ray);
    return;
  }
  uint bits = floatBitsToUint(rounded);
  uint column = rays;
  if (wants(kIncidence)) {
    double cosine = abs(p.along);
    sure = settled(min(cosine, 1.0LF), p.alongDoubt, rounded) && sure;
    put(column, ray, floatBitsToUint(rounded));
  }
  if (wants(kReflectance)) {
    uvec4 material = texelFetch(materials, int(p.label.y >> 16));
    uint reflectance = material.x;
    if ((material.w & kTextured) != 0u) {
      sure = texelAt(p, range, doubt, o, d, material, reflectance) && sure;
    }
    put(column, ray, reflectance & ~kLetsPass);
  }
  if (wants(kInstance)) put(column, ray, p.instance);
  if (wants(kSemantic | kMaterial)) put(column, ray, p.label.y);
  if (wants(kPrimitive)) put(column, ray, p.label.z);
  if (wants(kNormal)) {
    dvec3 towards = p.along > 0.0LF ? -p.normal : p.normal;
    for (int k = 0; k < 3; ++k) {
      sure = settled(towards[k], p.normalDoubt[k], rounded) && sure;
      hitColumns[column + 3u * ray + uint(k)] = floatBitsToUint(rounded);
    }
  }
  hitColumns[ray] = sure ? bits : kOpen;
}
)";

}  // namespace

std::string DeviceResolver::shader(const std::string& parameters) {
  const auto channel = [](const char* name, Channel c) { return glslConstant(name, static_cast<std::uint32_t>(c)); };
  const auto verdict = [](const char* name, RayVerdict v) { return glslConstant(name, static_cast<std::uint32_t>(v)); };
  return "layout(std140, binding = 0) uniform Parameters { double nearest, farthest; uint channels, rays; " +
         parameters + " };\n" + channel("kNormal", Channel::Normal) + channel("kInstance", Channel::Instance) +
         channel("kSemantic", Channel::Semantic) + channel("kMaterial", Channel::Material) +
         channel("kPrimitive", Channel::Primitive) + channel("kReflectance", Channel::Reflectance) +
         channel("kIncidence", Channel::Incidence) + verdict("kOpen", RayVerdict::Open) +
         verdict("kExhaustedRay", RayVerdict::Exhausted) + verdict("kLeftRay", RayVerdict::Left) +
         glslConstant("kInfinite", std::bit_cast<std::uint32_t>(kMiss)) + glslConstant("kLetsPass", kLetsPass) +
         glslConstant("kCutOut", kCutOut + 0u) + glslConstant("kTextured", kTextured + 0u) +
         glslConstant("kMoving", static_cast<std::uint32_t>(Standing::Moving)) + kDeclared + kHit;
}

}  // namespace scanmill
