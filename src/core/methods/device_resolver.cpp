#include "methods/device_resolver.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>
#include <tuple>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/world/resolve.h"
#include "scene/assets/texture.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

using enum ComputeTable::Texel;

constexpr std::size_t kGrain = 16384;
constexpr std::uint32_t kLetsPass = 0x80000000u;  // of a texel; the other bits are its reflectance

using Word = std::array<std::uint32_t, 4>;

std::uint32_t bits(float f) {
  return std::bit_cast<std::uint32_t>(f);
}

Word wordOf(double a, double b) {
  return std::bit_cast<Word>(std::array{a, b});
}

// Two words of the plane, one of what the triangle says: the object (instance id where baked), class | material << 16,
// its index in its mesh, and 1 + its place among the textured triangles.
struct Record {
  Word normalXY, normalZOffset, label;
};

// Corners (m, in the block's frame) with u, and v behind them.
struct TexturedTriangle {
  std::array<Word, 4> words;
};

// A block's place: its first record, the id of the mesh's first instance, how it is placed; then originFromMesh in
// rows, and as rows of the same length normalFromMesh or, where it moves, originFromMesh at the end of the revolution.
enum class Standing : std::uint32_t { Baked, Placed, Moving };
struct Stand {
  Word head;
  std::array<Word, 12> rows;
};
static_assert(sizeof(Stand) == 13 * sizeof(Word));

void setRows(const Mat3& m, const Vec3d& translation, Word* words) {
  const auto row = [&](double Vec3d::*axis) {
    *words++ = wordOf(m.x.*axis, m.y.*axis);
    *words++ = wordOf(m.z.*axis, translation.*axis);
  };
  row(&Vec3d::x);
  row(&Vec3d::y);
  row(&Vec3d::z);
}

// The scene's materials, and the reflectance of every texel of theirs.
class Materials {
 public:
  explicit Materials(const Scene& scene) {
    for (const Material& material : scene.materials) words.push_back(wordFor(material));
    if (words.empty()) words.push_back({});
  }

  bool texelsMatter(std::uint16_t material) const { return words[material][3] != 0; }

  static constexpr std::uint32_t kTextured = 1;  // its texels scale the reflectance
  // Reflectance, first texel, width | height << 16, and why texels are looked at (0: they are not).
  std::vector<Word> words;
  std::vector<std::uint32_t> texels;

 private:
  Word wordFor(const Material& material) {
    const CompactMaterial base = compact(material);
    const bool cut = material.alphaTested && material.texture != nullptr;
    if (base.texture == nullptr && !cut) return {bits(base.reflectance), 0, 0, 0};
    const Texture& texture = *material.texture;
    constexpr std::uint32_t kMost = 0xFFFF;
    if (texture.width > kMost || texture.height > kMost) {
      throw Error(
          fmt::format("'{}' has more than {} texels a side, too many for a graphics card", texture.file, kMost));
    }
    const auto key = std::tuple(&texture, base.textureGain, base.reflectance, cut ? material.alphaCutoff : -1.0f);
    const auto [known, added] = firstOf_.emplace(key, static_cast<std::uint32_t>(texels.size()));
    if (added) append(material, base, cut);
    return {bits(base.reflectance), known->second, texture.width | texture.height << 16,
            (base.texture != nullptr ? kTextured : 0u) | (cut ? 2u : 0u)};
  }

  void append(const Material& material, const CompactMaterial& base, bool cut) {
    const Texture& texture = *material.texture;
    const std::size_t first = texels.size();
    const std::size_t count = std::size_t{texture.width} * texture.height;
    texels.resize(first + count);
    parallelFor(count, kGrain, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        const std::uint8_t* texel = &texture.rgba[4 * i];
        texels[first + i] = bits(base.texture != nullptr ? base.ofTexel(texel) : base.reflectance) |
                            (cut && letsPass(material, texel) ? kLetsPass : 0u);
      }
    });
  }

  std::map<std::tuple<const Texture*, float, float, float>, std::uint32_t> firstOf_;
};

TexturedTriangle texturedTriangle(const TriangleBlock& block, std::uint32_t triangle) {
  const Triangle& corners = block.corners[triangle];
  TexturedTriangle made{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3f& p = block.vertices[corners[k]];
    const Vec2f uv = block.uvs.empty() ? Vec2f{} : block.uvs[corners[k]];
    made.words[k] = {bits(p.x), bits(p.y), bits(p.z), bits(uv.x)};
    made.words[3][k] = bits(uv.y);
  }
  return made;
}

void appendBlock(const TriangleBlock& block, const Materials& materials, std::vector<Record>& records,
                 std::vector<TexturedTriangle>& textured) {
  const std::size_t first = records.size();
  records.resize(first + block.triangles.size());
  parallelFor(block.triangles.size(), kGrain, [&](std::size_t from, std::size_t to) {
    for (std::size_t t = from; t < to; ++t) {
      const BlockTriangle& triangle = block.triangles[t];
      const HitSurface& surface = block.surfaces[triangle.surface];
      records[first + t] = {
          wordOf(triangle.normal.x, triangle.normal.y),
          wordOf(triangle.normal.z, triangle.offset),
          {surface.instance, surface.semantic | std::uint32_t{surface.material} << 16, triangle.primitive, 0}};
    }
  });
  for (std::uint32_t t = 0; t < block.triangles.size(); ++t) {
    if (!materials.texelsMatter(block.surfaceOf(t).material)) continue;
    textured.push_back(texturedTriangle(block, t));
    records[first + t].label[3] = static_cast<std::uint32_t>(textured.size());
  }
}

std::uint32_t bitsOf(Channels channels) {
  std::uint32_t set = 0;
  for (std::uint32_t bit = 1; bit < 0x100u; bit <<= 1) set |= channels.has(static_cast<Channel>(bit)) ? bit : 0u;
  return set;
}

// Where columns begin that are asked for, in words of 4 bytes. Class and material share one.
struct ColumnPlaces {
  ColumnPlaces(Channels channels, std::size_t rays) : end(rays) {
    const auto next = [&](bool asked, std::size_t words) {
      const std::size_t at = end;
      if (asked) end += words * rays;
      return at;
    };
    incidence = next(channels.has(Channel::Incidence), 1);
    reflectance = next(channels.has(Channel::Reflectance), 1);
    instance = next(channels.has(Channel::Instance), 1);
    label = next(channels.has(Channel::Semantic) || channels.has(Channel::Material), 1);
    primitive = next(channels.has(Channel::Primitive), 1);
    normal = next(channels.has(Channel::Normal), 3);
  }
  std::size_t end;  // the range begins at 0
  std::size_t incidence, reflectance, instance, label, primitive, normal;
};

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

// Whether a float32 has the same bits wherever within the doubt the value lies.
bool settled(double value, double doubt, out float rounded) {
  rounded = float(value);
  if (doubt == 0.0LF) return true;
  return float(value - doubt) == rounded && float(value + doubt) == rounded && abs(rounded) > 1e-30;
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
      turned = yz * p.normal.x + zx * p.normal.y + xy * p.normal.z;
      determinant = sum3(columnX, yz);
      if (determinant < 0.0LF) turned = -turned;
      determinant = abs(determinant);
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
  vec2 uv;
  bool sure = true;
  for (int k = 0; k < 2; ++k) {
    dvec3 v = dvec3(k == 0 ? vec3(u[0], u[1], u[2]) : uintBitsToFloat(behind.xyz));
    double value = first * v.x + second * v.y + third * v.z;
    double off = blur * (abs(v.y - v.x) + abs(v.z - v.x)) + (abs(v.x) + abs(v.y) + abs(v.z)) * (4.0LF * kSlack);
    float rounded;
    sure = settled(value, off, rounded) && sure;
    uv[k] = rounded;
  }
  uvec2 sides = uvec2(material.z & 0xFFFFu, material.z >> 16);
  precise vec2 part = uv - floor(uv);
  precise vec2 place = part * vec2(sides);
  uvec2 index = min(uvec2(place), sides - 1u) * uvec2(greaterThan(part, vec2(0.0)));
  texel = texelFetch(texels, int(material.y + index.y * sides.x + index.x)).x;
  return sure;
}

// Whether the triangle's texture lets the ray pass; `sure` is false where rounding could decide it.
bool letsPass(Plane p, double range, double doubt, dvec3 o, dvec3 d, out bool sure) {
  sure = true;
  uvec4 material = texelFetch(materials, int(p.label.y >> 16));
  if ((material.w & 2u) == 0u) return false;
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

DeviceResolver::DeviceResolver(const ComputeDevice& device, std::uint64_t most)
    : device_(device),
      most_(most),
      columns_(device),
      records_(device),
      stands_(device),
      materials_(device),
      reflectances_(device),
      textured_(device) {
  // Buffers without storage cannot be read from.
  for (ComputeBuffer* buffer : {&records_, &stands_, &materials_, &reflectances_, &textured_}) buffer->reserve(16);
}

template <class T>
void DeviceResolver::hold(ComputeBuffer& buffer, ComputeTable::Texel texel, std::span<const T> array,
                          const char* what) {
  holdTable(device_, buffer, texel, std::as_bytes(array), most_, what);
}

void DeviceResolver::holdMeshes(const World& world) {
  const Materials materials(*world.scene);
  std::vector<Record> records;
  std::vector<TexturedTriangle> textured;
  firstRecord_.clear();
  appendBlock(world.baked, materials, records, textured);
  for (const std::unique_ptr<TriangleBlock>& block : world.shared->blocks) {
    if (block == nullptr) continue;
    firstRecord_[block.get()] = static_cast<std::uint32_t>(records.size());
    appendBlock(*block, materials, records, textured);
  }
  hold(records_, Uint32x4, std::span<const Record>(records), "scene's planes and labels");
  hold(textured_, Uint32x4, std::span<const TexturedTriangle>(textured), "scene's textured triangles");
  hold(materials_, Uint32x4, std::span<const Word>(materials.words), "scene's materials");
  hold(reflectances_, Uint32, std::span<const std::uint32_t>(materials.texels), "scene's textures");
}

void DeviceResolver::holdPlaces(const World& world) {
  std::vector<Stand> stands(1 + world.placed.size());
  const auto standing = [](Standing s) { return static_cast<std::uint32_t>(s); };
  stands[0].head = {0, 0, standing(Standing::Baked), 0};
  for (std::size_t k = 0; k < world.placed.size(); ++k) {
    const PlacedBlock& placed = world.placed[k];
    Stand& stand = stands[1 + k];
    stand.head = {firstRecord_.at(placed.block), placed.firstInstanceId,
                  standing(placed.moves ? Standing::Moving : Standing::Placed), 0};
    setRows(placed.originFromMesh.linear, placed.originFromMesh.translation, stand.rows.data());
    if (placed.moves) {
      setRows(placed.atEnd.linear, placed.atEnd.translation, stand.rows.data() + 6);
    } else {
      setRows(placed.normalFromMesh, {}, stand.rows.data() + 6);
    }
  }
  hold(stands_, Uint32x4, std::span<const Stand>(stands), "scene's placed meshes");
}

ResolverBlock DeviceResolver::block(const BeamTable& beams, Channels channels, std::size_t rays) {
  const RangeLimits limits = limitsOf(beams);
  return {limits.nearest, limits.farthest, bitsOf(channels), static_cast<std::uint32_t>(rays)};
}

std::uint64_t DeviceResolver::bytesPerRay(Channels channels) {
  return ColumnPlaces(channels, 1).end * sizeof(std::uint32_t);
}

void DeviceResolver::reserve(Channels channels, std::size_t rays) {
  columns_.reserve(bytesPerRay(channels) * rays);
}

ComputeTable DeviceResolver::table(std::size_t binding) const {
  const std::array<const ComputeBuffer*, kTables> buffers{&records_, &stands_, &materials_, &reflectances_, &textured_};
  return {buffers[binding], binding == 3 ? Uint32 : Uint32x4};
}

void DeviceResolver::take(std::span<const std::byte> columns, std::size_t first, std::size_t rays, Hits& hits,
                          std::vector<UndecidedRay>& undecided) {
  const ColumnPlaces places(hits.channels, rays);
  std::mutex mutex;
  const std::size_t before = undecided.size();
  parallelFor(rays, kGrain, [&](std::size_t from, std::size_t to) {
    const auto copy = [&](std::size_t word, std::size_t words, auto* values) {
      std::memcpy(values, columns.data() + 4 * (word + words * from), 4 * words * (to - from));
    };
    const std::size_t at = first + from;
    copy(0, 1, &hits.range[at]);
    if (!hits.incidence.empty()) copy(places.incidence, 1, &hits.incidence[at]);
    if (!hits.reflectance.empty()) copy(places.reflectance, 1, &hits.reflectance[at]);
    if (!hits.instance.empty()) copy(places.instance, 1, &hits.instance[at]);
    if (!hits.primitive.empty()) copy(places.primitive, 1, &hits.primitive[at]);
    if (!hits.normal.empty()) copy(places.normal, 3, &hits.normal[at]);
    if (!hits.semantic.empty() || !hits.material.empty()) {
      std::array<std::uint32_t, 256> labels;
      for (std::size_t i = from; i < to; i += labels.size()) {
        const std::size_t some = std::min(labels.size(), to - i);
        std::memcpy(labels.data(), columns.data() + 4 * (places.label + i), 4 * some);
        for (std::size_t k = 0; k < some && !hits.semantic.empty(); ++k)
          hits.semantic[first + i + k] = static_cast<std::uint16_t>(labels[k]);
        for (std::size_t k = 0; k < some && !hits.material.empty(); ++k)
          hits.material[first + i + k] = static_cast<std::uint16_t>(labels[k] >> 16);
      }
    }
    std::vector<UndecidedRay> mine;
    for (std::size_t i = at; i < first + to; ++i) {
      if (!std::isnan(hits.range[i])) continue;
      mine.push_back({static_cast<std::uint32_t>(i), static_cast<RayVerdict>(bits(hits.range[i]))});
    }
    if (mine.empty()) return;
    const std::scoped_lock lock(mutex);
    undecided.insert(undecided.end(), mine.begin(), mine.end());
  });
  std::sort(undecided.begin() + static_cast<std::ptrdiff_t>(before), undecided.end(),
            [](const UndecidedRay& a, const UndecidedRay& b) { return a.ray < b.ray; });
}

std::string DeviceResolver::shader(const std::string& parameters) {
  const auto channel = [](const char* name, Channel c) { return glslConstant(name, static_cast<std::uint32_t>(c)); };
  const auto verdict = [](const char* name, RayVerdict v) { return glslConstant(name, static_cast<std::uint32_t>(v)); };
  return "layout(std140, binding = 0) uniform Parameters { double nearest, farthest; uint channels, rays; " +
         parameters + " };\n" + channel("kNormal", Channel::Normal) + channel("kInstance", Channel::Instance) +
         channel("kSemantic", Channel::Semantic) + channel("kMaterial", Channel::Material) +
         channel("kPrimitive", Channel::Primitive) + channel("kReflectance", Channel::Reflectance) +
         channel("kIncidence", Channel::Incidence) + verdict("kOpen", RayVerdict::Open) +
         verdict("kExhaustedRay", RayVerdict::Exhausted) + verdict("kLeftRay", RayVerdict::Left) +
         glslConstant("kInfinite", bits(kMiss)) + glslConstant("kLetsPass", kLetsPass) +
         glslConstant("kTextured", Materials::kTextured + 0u) +
         glslConstant("kMoving", static_cast<std::uint32_t>(Standing::Moving)) +
         "const double kSlack = 8.8817841970012523e-16LF;  // eight roundings\n" + kDeclared + kHit;
}

}  // namespace scanmill
