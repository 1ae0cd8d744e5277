#include "methods/gpu/device_march.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/field/march_job.h"
#include "methods/field/march_rule.h"
#include "methods/gpu/device_resolver.h"

namespace scanmill {

namespace {

// The parameters of marchShader(), in std140 layout.
struct MarchParameters {
  std::int32_t lastLevel;
  float perReach;
  float metres;
  std::uint32_t steps;
  std::uint32_t count;
  std::uint32_t onlyBehindHoles;
  std::uint32_t unused[2];
};
static_assert(sizeof(MarchParameters) == 32);

MarchParameters marchParameters(const DistanceField& field, std::uint32_t steps, std::size_t count) {
  MarchParameters block{};
  block.lastLevel = static_cast<std::int32_t>(field.levels.size()) - 1;
  block.perReach = 1.0f / field.shape.reach;
  block.metres = static_cast<float>(field.shape.voxel);
  block.steps = steps;
  block.count = static_cast<std::uint32_t>(count);
  return block;
}

// A corner and the two edges from it.
using DeviceTriangle = std::array<std::array<float, 4>, 3>;

std::vector<DeviceTriangle> deviceTriangles(const TriangleBlock& block) {
  std::vector<DeviceTriangle> made(block.corners.size());
  parallelFor(made.size(), 16384, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      const Triangle& corners = block.corners[t];
      const Vec3f a = block.vertices[corners[0]];
      const Vec3f ab = block.vertices[corners[1]] - a;
      const Vec3f ac = block.vertices[corners[2]] - a;
      made[t] = {{{a.x, a.y, a.z, 0}, {ab.x, ab.y, ab.z, 0}, {ac.x, ac.y, ac.z, 0}}};
    }
  });
  return made;
}

using enum ComputeTable::Texel;

const std::string kRemedy = ": take coarser voxels (voxel_m) or fewer levels";

using DeviceLevel = std::array<std::uint32_t, 8>;

std::vector<DeviceLevel> deviceLevels(const DistanceField& field) {
  std::vector<DeviceLevel> made;
  for (const FieldLevel& level : field.levels) {
    const auto bits = [&](std::size_t k) { return std::bit_cast<std::uint32_t>(level.offset[k]); };
    made.push_back({bits(0), bits(1), bits(2), level.firstEntry, level.bricks[0], level.bricks[1], level.bricks[2], 0});
  }
  return made;
}

// Returns the constants that several programs share: the outcomes of particles and the layout of bricks.
std::string fieldConstants() {
  return glslConstant("kDistanceStep", kDistanceStep) + glslConstant("kBrickStride", kBrickStride + 0u) +
         glslConstant("kNoWord", kNoWord) + glslConstant("kFullBrick", kFullBrick) +
         glslConstant("kHit", static_cast<std::uint32_t>(Outcome::Hit)) +
         glslConstant("kExhausted", static_cast<std::uint32_t>(Outcome::Exhausted)) +
         glslConstant("kPassesHole", kPassesHole);
}

static_assert(kChannels.size() == 8, "give the new channel a constant here, and fill it in shaders/hit_columns.glsl");

std::string resolverConstants() {
  const auto channel = [](const char* name, Channel c) { return glslConstant(name, static_cast<std::uint32_t>(c)); };
  const auto reason = [](const char* name, UnresolvedReason v) {
    return glslConstant(name, static_cast<std::uint32_t>(v));
  };
  return channel("kNormal", Channel::Normal) + channel("kInstance", Channel::Instance) +
         channel("kSemantic", Channel::Semantic) + channel("kMaterial", Channel::Material) +
         channel("kPrimitive", Channel::Primitive) + channel("kReflectance", Channel::Reflectance) +
         channel("kIncidence", Channel::Incidence) + reason("kRounding", UnresolvedReason::Rounding) +
         reason("kStepsUsedUp", UnresolvedReason::StepsUsedUp) + reason("kLeftField", UnresolvedReason::LeftField) +
         glslConstant("kInfinite", std::bit_cast<std::uint32_t>(kMiss)) + glslConstant("kLetsPass", kLetsPass) +
         glslConstant("kCutOut", kCutOut + 0u) + glslConstant("kTextured", kTextured + 0u);
}

// Returns the text of a program: constants, followed by the text of a file.
std::string program(std::string constants, std::string_view text) {
  return constants.append(text);
}

}  // namespace

DeviceMarch::DeviceMarch(const ComputeDevice& device)
    : device_(device),
      marchers_(device, "particle", marchShader),
      particles_(device),
      records_(device),
      triangles_(device),
      fields_(device) {}

void DeviceMarch::ensureUploaded(const std::shared_ptr<const DistanceField>& field,
                                 const std::shared_ptr<const World>& world) {
  fields_.ensureUploaded(field);
  if (!field->shape.lists || world_.lock() == world) return;
  world_.reset();
  const std::vector<DeviceTriangle> triangles = deviceTriangles(world->baked);
  uploadTable(device_, triangles_, ComputeTable::Texel::Float32x4, std::as_bytes(std::span(triangles)),
              "scene's triangles", ": take `refine: none`, which does not need them");
  world_ = world;
}

void DeviceMarch::reserve(bool lists, std::size_t particles) {
  particles_.reserve((lists ? kMostColumns : kFewestColumns) * particles * sizeof(float));
  records_.reserve(5 * particles * sizeof(float));
}

void DeviceMarch::run(const DistanceField& field, std::uint32_t steps, std::size_t particles, Marching which) {
  MarchParameters block = marchParameters(field, steps, particles);
  block.onlyBehindHoles = which == Marching::BehindHoles ? 1 : 0;
  marchers_.of(field.shape.lists)
      .run(particles, {&particles_, &records_}, std::as_bytes(std::span(&block, 1)),
           {fields_.levels(),
            fields_.table(),
            fields_.distances(),
            fields_.words(),
            fields_.lists(),
            {&triangles_, ComputeTable::Texel::Float32x4}});
}

DeviceFields::UploadedPool::UploadedPool(const ComputeDevice& device)
    : levels(device),
      table(device),
      distances{ComputeBuffer(device)},
      words{ComputeBuffer(device)},
      lists{ComputeBuffer(device)} {}

std::uint64_t DeviceFields::UploadedPool::bytes() const {
  return levels.bytes() + table.bytes() + distances.buffer.bytes() + words.buffer.bytes() + lists.buffer.bytes();
}

// Moves the pool's entry of pools_ to the front. If the pool has none, it gets the entry of a pool that no longer
// exists, otherwise a new entry if memory suffices, otherwise the least recently used entry.
void DeviceFields::take(const std::shared_ptr<const BrickPool>& pool) {
  auto found = std::find_if(pools_.begin(), pools_.end(), [&](const UploadedPool& p) { return p.pool.lock() == pool; });
  if (found == pools_.end()) {
    found = std::find_if(pools_.begin(), pools_.end(), [](const UploadedPool& p) { return p.pool.expired(); });
    if (found == pools_.end()) {
      std::uint64_t bytes = 0;
      for (const UploadedPool& other : pools_) bytes += other.bytes();
      // Assumes that the new pool will have the mean size of the others.
      const bool fits = pools_.empty() || bytes + bytes / pools_.size() <= kMostBytes;
      found = fits ? pools_.emplace(pools_.end(), device_) : std::prev(pools_.end());
    }
    for (Array* array : {&found->distances, &found->words, &found->lists}) array->uploadedBytes = 0;
    found->field.reset();
    found->pool = pool;
  }
  pools_.splice(pools_.begin(), pools_, found);
}

void DeviceFields::ensureUploaded(const std::shared_ptr<const DistanceField>& field) {
  take(field->pool);
  if (pools_.front().field.lock() == field) return;
  try {
    upload(field);
  } catch (const Error&) {
    if (pools_.size() == 1) throw;
    pools_.erase(std::next(pools_.begin()), pools_.end());
    upload(field);
  }
}

void DeviceFields::upload(const std::shared_ptr<const DistanceField>& field) {
  UploadedPool& pool = pools_.front();
  pool.field.reset();  // the buffers belong to no field until all are filled
  const std::vector<DeviceLevel> levels = deviceLevels(*field);
  uploadTable(device_, pool.levels, Uint32x4, std::as_bytes(std::span(levels)), "levels", kRemedy);
  uploadTable(device_, pool.table, Uint32, std::as_bytes(std::span(field->table)), "table of bricks", kRemedy);
  append(pool.distances, Uint16, field->distance, field->pool->distance.size(), "distances");
  append(pool.words, Uint32, field->word, field->pool->word.size(), "triangles at corners");
  append(pool.lists, Uint32, field->lists, field->pool->lists.size(), "lists of triangles");
  pool.field = field;
}

// Uploads the part of `all` that is not on the device yet. `room`: largest number of elements of the array.
template <class T>
void DeviceFields::append(Array& array, ComputeTable::Texel texel, std::span<const T> all, std::size_t room,
                          const char* what) {
  const auto bytes = std::as_bytes(all);
  checkTable(device_, texel, bytes.size(), what, kRemedy);
  if (array.buffer.bytes() < bytes.size()) {
    array.uploadedBytes = 0;
    array.buffer.reserve(std::min<std::uint64_t>(room, device_.limits().tableTexels) * sizeof(T));
  }
  if (array.uploadedBytes >= bytes.size()) return;
  array.buffer.write(array.uploadedBytes, bytes.subspan(array.uploadedBytes));
  array.uploadedBytes = bytes.size();
}

extern const std::string_view kLaunchShader;
extern const std::string_view kMarchNearestShader;
extern const std::string_view kMarchListsShader;
extern const std::string_view kResolveNearestShader;
extern const std::string_view kResolveListsShader;

std::string launchShader(bool lists) {
  return program(glslConstant("kGroupColumns", MarchJob::kGroupColumns + 0u) +
                     fmt::format("const bool kLists = {};\n", lists) + glslConstant("kLeftToCpu", kLeftToCpu),
                 kLaunchShader);
}

std::string marchShader(bool lists) {
  return program(
      fieldConstants() + glslConstant("kLastOfList", kLastOfList) + glslConstant("kNearestLimit", kNearestLimit) +
          glslConstant("kListLimit", kListLimit) + glslConstant("kHitDistance", kHitDistance) +
          glslConstant("kMiss", static_cast<std::uint32_t>(Outcome::Miss)) +
          glslConstant("kEmptyChordFactor", kEmptyChordFactor) +
          glslConstant("kNearestChordFactor", kNearestChordFactor) +
          glslConstant("kListChordFactor", kListChordFactor) + glslConstant("kTriangleMargin", kTriangleMargin) +
          glslConstant("kBackwardTolerance", kBackwardTolerance) + glslConstant("kTieMargin", kTieMargin) +
          glslConstant("kFaceOvershoot", kFaceOvershoot) + glslConstant("kExitPlane", kExitPlane),
      lists ? kMarchListsShader : kMarchNearestShader);
}

std::string resolveShader(bool lists) {
  return program(fieldConstants() + resolverConstants() + glslConstant("kGroupColumns", MarchJob::kGroupColumns + 0u) +
                     glslConstant("kLeftToCpu", kLeftToCpu) + glslConstant("kDone", kParticleDone) +
                     glslConstant("kHoleSkip", kHoleSkip) + glslConstant("kHoleSkipShare", kHoleSkipShare),
                 lists ? kResolveListsShader : kResolveNearestShader);
}

}  // namespace scanmill
