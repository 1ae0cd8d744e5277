// Lookups in a distance field (methods/field/distance_field.h). The including file defines the macros kLevelsBinding,
// kTableBinding and kTrianglesBinding, the bindings of the tables.

layout(binding = kLevelsBinding) uniform usamplerBuffer levels;  // two uvec4 each: see DeviceFields::levels()
layout(binding = kTableBinding) uniform usamplerBuffer table;
layout(binding = kTrianglesBinding) uniform usamplerBuffer trianglesOrLists;

uint fetch(usamplerBuffer array, uint i) {
  return texelFetch(array, int(i)).x;
}

struct Voxel {
  float scale;      // side of a voxel of level 0, in voxels of the level
  float voxelSize;  // side of a voxel of the level, in voxels of level 0
  vec3 f;  // position in the voxel
  vec3 r;  // position relative to the nearest corner
  vec3 b;  // position relative to the brick's centre
  bool full;  // true if the voxel's brick is near a surface
  uint brick;    // if full, the brick's number, otherwise the bits of the distance from its centre to surfaces
  uint cell;     // index of the voxel's first corner, if its brick is full
  uint nearest;  // index of the corner nearest to the point, if the brick is full
};

// Returns the voxel of `level` that contains the point `q` (field's frame).
Voxel voxelOf(vec3 q, int level) {
  uvec4 origin = texelFetch(levels, 2 * level);  // xyz: bits of the offset; w: index of the level's first entry
  uvec4 box = texelFetch(levels, 2 * level + 1);
  Voxel v;
  v.scale = uintBitsToFloat(uint(127 - level) << 23);
  v.voxelSize = uintBitsToFloat(uint(127 + level) << 23);
  precise vec3 u = max(q * v.scale + uintBitsToFloat(origin.xyz), vec3(0.0));
  ivec3 corner = min(ivec3(u), ivec3(box.xyz) * 8 - 1);
  uvec3 brick = uvec3(corner) >> 3u;
  uvec3 inBrick = uvec3(corner) & 7u;
  precise vec3 f = u - vec3(corner);
  precise vec3 b = u - vec3(ivec3(brick) * 8 + 4);
  bvec3 isUpper = greaterThanEqual(f, vec3(0.5));
  precise vec3 r = f - vec3(isUpper);
  uvec3 up = uvec3(isUpper);
  uint entry = fetch(table, origin.w + (brick.z * box.y + brick.y) * box.x + brick.x);
  v.f = f;
  v.b = b;
  v.r = r;
  v.full = entry >= kFullBrick;
  v.brick = v.full ? entry - kFullBrick : entry;
  v.cell = v.full ? v.brick * kBrickStride + (inBrick.z * 9u + inBrick.y) * 9u + inBrick.x : 0u;
  v.nearest = v.cell + (up.z * 9u + up.y) * 9u + up.x;
  return v;
}
