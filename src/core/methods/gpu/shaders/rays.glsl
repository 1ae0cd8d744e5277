// The rays of shots, from the tables of DeviceBeams.

layout(std430, binding = 0) readonly restrict buffer Directions { double directions[]; };
layout(std430, binding = 1) readonly restrict buffer Origins { float origins[]; };
layout(std430, binding = 2) readonly restrict buffer Poses { double poses[]; };  // 12 numbers per pose: see appendPoses
layout(std430, binding = 3) readonly restrict buffer Steps { uint stepOfColumn[]; };

// Assumed relative error of quotients and roots: 2^-48, or 16 ulp. OpenGL allows 2.5 ulp for quotients, 4.5 for roots.
const double kSlack = 3.5527136788005009e-15LF;

// True if all values that differ from `value` by at most `errorBound` round to the same float32, which is `rounded`.
bool roundsAlike(double value, double errorBound, out float rounded) {
  rounded = float(value);
  if (errorBound == 0.0LF) return value == 0.0LF || abs(value) > 1e-37LF;  // devices may flush smaller values to 0
  return float(value - errorBound) == rounded && float(value + errorBound) == rounded && abs(rounded) > 1e-30;
}

// Returns the dot product of `v` and a row of a pose's rotation; the row starts at poses[row].
double rotated(uint row, dvec3 v) {
  precise double product = poses[row] * v.x + poses[row + 1u] * v.y + poses[row + 2u] * v.z;
  return product;
}

// Returns the origin (m, relative to the world's origin) and the unit direction of a ray, with the bits of setUpRays()
// (methods/world/resolve.h). `firstPose`: index of the shot's first pose in `poses`. `withOrigins`: reads `origins`.
void rayOf(uint ray, uint column, uint firstPose, bool withOrigins, out dvec3 o, out dvec3 d) {
  uint pose = 12u * (firstPose + stepOfColumn[column]);
  dvec3 direction = dvec3(directions[3u * ray], directions[3u * ray + 1u], directions[3u * ray + 2u]);
  d = dvec3(rotated(pose, direction), rotated(pose + 4u, direction), rotated(pose + 8u, direction));
  o = dvec3(poses[pose + 3u], poses[pose + 7u], poses[pose + 11u]);
  if (withOrigins) {
    dvec3 shift = dvec3(origins[3u * ray], origins[3u * ray + 1u], origins[3u * ray + 2u]);
    precise dvec3 moved = o + dvec3(rotated(pose, shift), rotated(pose + 4u, shift), rotated(pose + 8u, shift));
    o = moved;
  }
}
