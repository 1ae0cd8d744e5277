// Computes the planes, labels and texels of hit triangles, and writes the columns of hits, with the same bits as on the
// CPU. The including file declares a uniform block with the members of ResolverParameters (device_resolver.h): nearest,
// farthest, channels, rays. Storage buffer at binding 5: the columns.

layout(std430, binding = 5) writeonly restrict buffer HitColumns { uint hitColumns[]; };
layout(binding = 0) uniform usamplerBuffer planeRecords;
layout(binding = 1) uniform usamplerBuffer materials;
layout(binding = 2) uniform usamplerBuffer texels;
layout(binding = 3) uniform usamplerBuffer texturedTriangles;

// The plane of a triangle, relative to the world's origin, and its labels, with the same bits as on the CPU.
struct Plane {
  dvec3 normal;
  double offset;
  double along;  // dot product of the normal and the ray's direction
  uvec4 label;
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

void planeRecord(uint record, out dvec3 normal, out double offset) {
  uvec4 a = texelFetch(planeRecords, int(3u * record));
  uvec4 b = texelFetch(planeRecords, int(3u * record + 1u));
  normal = dvec3(packDouble2x32(a.xy), packDouble2x32(a.zw), packDouble2x32(b.xy));
  offset = packDouble2x32(b.zw);
}

Plane planeOf(uint triangle, dvec3 d) {
  Plane p;
  planeRecord(triangle, p.normal, p.offset);
  p.label = texelFetch(planeRecords, int(3u * triangle + 2u));
  p.along = sum3(p.normal, d);
  return p;
}

// Returns the range from `o` to the plane along the direction `d` with which planeOf() was called. The CPU's range
// differs by at most `errorBound`.
double distanceTo(Plane p, dvec3 o, out double errorBound) {
  precise double gap = p.offset - sum3(p.normal, o);
  double range = gap / p.along;
  errorBound = abs(range) * kSlack;
  return range;
}

// Returns the index of the texel at a texture coordinate, along an axis with `side` texels.
uint texelOf(float coordinate, uint side) {
  precise float fraction = coordinate - floor(coordinate);
  precise float position = fraction * float(side);
  return fraction > 0.0 ? min(uint(position), side - 1u) : 0u;
}

// Finds the texel at which the ray hits the triangle's texture. Returns false if rounding could lead to another texel.
bool texelAt(Plane p, double range, double errorBound, dvec3 o, dvec3 d, uvec4 material, out uint texel) {
  int at = int(4u * (p.label.w - 1u));
  uvec4 behind = texelFetch(texturedTriangles, at + 3);
  dvec3 corner[3];
  float u[3];
  for (int k = 0; k < 3; ++k) {
    uvec4 word = texelFetch(texturedTriangles, at + k);
    corner[k] = dvec3(uintBitsToFloat(word.xyz));
    u[k] = uintBitsToFloat(word.w);
  }
  dvec3 ab = corner[1] - corner[0];
  dvec3 ac = corner[2] - corner[0];
  dvec3 point = o + d * range - corner[0];
  dvec3 n = across(ab, ac);
  double square = sum3(n, n);
  double second = clamp(sum3(n, across(point, ac)) / square, 0.0LF, 1.0LF);
  double third = clamp(sum3(n, across(ab, point)) / square, 0.0LF, 1.0LF - second);
  double size = largest(corner[0]) + largest(corner[1]) + largest(corner[2]) + largest(o) + abs(range);
  double blur = (errorBound + size * (8.0LF * kSlack)) * 16.0LF * (largest(ab) + largest(ac) + largest(point)) /
                sqrt(square);
  double first = 1.0LF - second - third;
  uvec2 sides = uvec2(material.z & 0xFFFFu, material.z >> 16);
  uvec2 index;
  bool certain = true;
  for (int k = 0; k < 2; ++k) {
    dvec3 v = dvec3(k == 0 ? vec3(u[0], u[1], u[2]) : uintBitsToFloat(behind.xyz));
    double value = first * v.x + second * v.y + third * v.z;
    double off = blur * (abs(v.y - v.x) + abs(v.z - v.x)) + (abs(v.x) + abs(v.y) + abs(v.z)) * (4.0LF * kSlack);
    // If `low` and `high` are in the same texel of the same repetition, all coordinates between them are in it too.
    float low = float(value - off);
    float high = float(value + off);
    index[k] = texelOf(low, sides[k]);
    certain = floor(low) == floor(high) && index[k] == texelOf(high, sides[k]) && certain;
  }
  texel = texelFetch(texels, int(material.y + index.y * sides.x + index.x)).x;
  return certain;
}

// True if the triangle's texture lets the ray pass. `certain` is false if rounding could change the result.
bool letsPass(Plane p, double range, double errorBound, dvec3 o, dvec3 d, out bool certain) {
  certain = true;
  uvec4 material = texelFetch(materials, int(p.label.y >> 16));
  if ((material.w & kCutOut) == 0u) return false;
  uint texel;
  certain = texelAt(p, range, errorBound, o, d, material, texel);
  return (texel & kLetsPass) != 0u;
}

bool wants(uint channel) {
  return (channels & channel) != 0u;
}

void putUnresolved(uint ray, uint reason) {
  hitColumns[ray] = reason;
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

void hit(uint ray, Plane p, double range, double errorBound, dvec3 o, dvec3 d) {
  float rounded;
  bool certain = roundsAlike(range, errorBound, rounded);
  if (abs(range - nearest) <= errorBound || abs(range - farthest) <= errorBound || p.along == 0.0LF) certain = false;
  if (certain && !(range >= nearest && range <= farthest)) {
    miss(ray);
    return;
  }
  uint bits = floatBitsToUint(rounded);
  uint column = rays;
  if (wants(kIncidence)) {
    double cosine = abs(p.along);
    certain = roundsAlike(min(cosine, 1.0LF), 0.0LF, rounded) && certain;
    put(column, ray, floatBitsToUint(rounded));
  }
  if (wants(kReflectance)) {
    uvec4 material = texelFetch(materials, int(p.label.y >> 16));
    uint reflectance = material.x;
    if ((material.w & kTextured) != 0u) {
      certain = texelAt(p, range, errorBound, o, d, material, reflectance) && certain;
    }
    put(column, ray, reflectance & ~kLetsPass);
  }
  if (wants(kInstance)) put(column, ray, p.label.x);
  if (wants(kSemantic | kMaterial)) put(column, ray, p.label.y);
  if (wants(kPrimitive)) put(column, ray, p.label.z);
  if (wants(kNormal)) {
    dvec3 towards = p.along > 0.0LF ? -p.normal : p.normal;
    for (int k = 0; k < 3; ++k) {
      certain = roundsAlike(towards[k], 0.0LF, rounded) && certain;
      hitColumns[column + 3u * ray + uint(k)] = floatBitsToUint(rounded);
    }
  }
  hitColumns[ray] = certain ? bits : kRounding;
}
