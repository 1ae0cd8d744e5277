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

// A triangle: a corner and the two edges from this corner (m, relative to the world's origin). Fourth components are
// not used.
using DeviceTriangle = std::array<std::array<float, 4>, 3>;

std::vector<DeviceTriangle> deviceTriangles(const TriangleBlock& block) {
  constexpr std::size_t kGrain = 16384;  // triangles per task
  std::vector<DeviceTriangle> triangles(block.corners.size());
  parallelForEach(triangles.size(), kGrain, [&](std::size_t t) {
    const Triangle& corners = block.corners[t];
    const Vec3f a = block.vertices[corners[0]];
    const Vec3f ab = block.vertices[corners[1]] - a;
    const Vec3f ac = block.vertices[corners[2]] - a;
    triangles[t] = {{{a.x, a.y, a.z, 0}, {ab.x, ab.y, ab.z, 0}, {ac.x, ac.y, ac.z, 0}}};
  });
  return triangles;
}

using enum ComputeTable::Texel;

const std::string kRemedy = ": take coarser voxels (voxel_m) or fewer levels";

using DeviceLevel = std::array<std::uint32_t, 8>;

// Returns the parameters of the field's levels, in the layout of DeviceFields::levels().
std::vector<DeviceLevel> deviceLevels(const DistanceField& field) {
  std::vector<DeviceLevel> levels;
  for (const FieldLevel& level : field.levels) {
    const auto bits = [&](std::size_t k) { return std::bit_cast<std::uint32_t>(level.offset[k]); };
    levels.push_back(
        {bits(0), bits(1), bits(2), level.firstEntry, level.bricks[0], level.bricks[1], level.bricks[2], 0});
  }
  return levels;
}

// Returns the constants that several programs share: the outcomes of particles and the layout of bricks.
std::string fieldConstants() {
  return glslConstant("kDistanceStep", kDistanceStep) + glslConstant("kBrickStride", kBrickStride + 0u) +
         glslConstant("kNoTriangle", kNoTriangle) + glslConstant("kFullBrick", kFullBrick) +
         glslConstant("kHit", static_cast<std::uint32_t>(Outcome::Hit)) +
         glslConstant("kExhausted", static_cast<std::uint32_t>(Outcome::Exhausted)) +
         glslConstant("kPassesHole", kPassesHole);
}

static_assert(kChannels.size() == 8, "give the new channel a constant here, and fill it in shaders/hit_columns.glsl");

// Returns the constants of hit_columns.glsl and resolve.glsl.
std::string resolverConstants() {
  std::string text;
  for (const auto& [name, channel] : {std::pair{"kNormal", Channel::Normal},
                                      {"kInstance", Channel::Instance},
                                      {"kSemantic", Channel::Semantic},
                                      {"kMaterial", Channel::Material},
                                      {"kPrimitive", Channel::Primitive},
                                      {"kReflectance", Channel::Reflectance},
                                      {"kIncidence", Channel::Incidence}}) {
    text += glslConstant(name, static_cast<std::uint32_t>(channel));
  }
  for (const auto& [name, reason] : {std::pair{"kRounding", UnresolvedReason::Rounding},
                                     {"kStepsUsedUp", UnresolvedReason::StepsUsedUp},
                                     {"kLeftField", UnresolvedReason::LeftField}}) {
    text += glslConstant(name, static_cast<std::uint32_t>(reason));
  }
  return text + glslConstant("kInfinite", std::bit_cast<std::uint32_t>(kMiss)) + glslConstant("kLetsPass", kLetsPass) +
         glslConstant("kCutOut", kCutOut + 0u) + glslConstant("kTextured", kTextured + 0u);
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
  constexpr std::size_t kRecordColumns = 5;  // number of columns of hit records: see march.glsl
  records_.reserve(kRecordColumns * particles * sizeof(std::uint32_t));
}

void DeviceMarch::run(const DistanceField& field, std::uint32_t maxSteps, std::size_t particles, Marching which) {
  const MarchParameters parameters{.lastLevel = static_cast<std::int32_t>(field.levels.size()) - 1,
                                   .perReach = 1.0f / field.shape.reach,
                                   .metres = static_cast<float>(field.shape.voxel),
                                   .steps = maxSteps,
                                   .count = static_cast<std::uint32_t>(particles),
                                   .onlyBehindHoles = which == Marching::BehindHoles ? 1u : 0u,
                                   .unused = {}};
  marchers_.of(field.shape.lists)
      .run(particles, {&particles_, &records_}, std::as_bytes(std::span(&parameters, 1)),
           {fields_.levels(),
            fields_.table(),
            fields_.distances(),
            fields_.trianglesOrLists(),
            fields_.lists(),
            {&triangles_, ComputeTable::Texel::Float32x4}});
}

DeviceFields::UploadedPool::UploadedPool(const ComputeDevice& device)
    : levels(device),
      table(device),
      distances{ComputeBuffer(device)},
      trianglesOrLists{ComputeBuffer(device)},
      lists{ComputeBuffer(device)} {}

std::uint64_t DeviceFields::UploadedPool::bytes() const {
  return levels.bytes() + table.bytes() + distances.buffer.bytes() + trianglesOrLists.buffer.bytes() +
         lists.buffer.bytes();
}

// Moves the pool's entry of pools_ to the front. A pool without an entry takes over the entry of a pool that no longer
// exists. If all pools exist, a new entry is added if kMostBytes allows this; otherwise the pool takes over the least
// recently used entry.
void DeviceFields::bringToFront(const std::shared_ptr<const BrickPool>& pool) {
  auto entry = std::ranges::find_if(pools_, [&](const UploadedPool& p) { return p.pool.lock() == pool; });
  if (entry == pools_.end()) {
    entry = std::ranges::find_if(pools_, [](const UploadedPool& p) { return p.pool.expired(); });
    if (entry == pools_.end()) {
      std::uint64_t bytes = 0;
      for (const UploadedPool& other : pools_) bytes += other.bytes();
      // Assumes that the new pool will have the mean size of the pools on the device.
      const bool fits = pools_.empty() || bytes + bytes / pools_.size() <= kMostBytes;
      entry = fits ? pools_.emplace(pools_.end(), device_) : std::prev(pools_.end());
    }
    for (Array* array : {&entry->distances, &entry->trianglesOrLists, &entry->lists}) array->uploadedBytes = 0;
    entry->field.reset();
    entry->pool = pool;
  }
  pools_.splice(pools_.begin(), pools_, entry);
}

void DeviceFields::ensureUploaded(const std::shared_ptr<const DistanceField>& field) {
  bringToFront(field->pool);
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
  append(pool.trianglesOrLists, Uint32, field->triangleOrList, field->pool->triangleOrList.size(),
         "triangles at corners");
  append(pool.lists, Uint32, field->lists, field->pool->lists.size(), "lists of triangles");
  pool.field = field;
}

// Uploads the elements that are not on the device yet; the array only ever grows at its end. If its buffer is too
// small, it gets space for `capacity` elements. `texel`: type of an element. `contents`: name of the array in messages.
template <class T>
void DeviceFields::append(Array& array, ComputeTable::Texel texel, std::span<const T> elements, std::size_t capacity,
                          const char* contents) {
  const auto bytes = std::as_bytes(elements);
  checkTable(device_, texel, bytes.size(), contents, kRemedy);
  if (array.buffer.bytes() < bytes.size()) {
    array.uploadedBytes = 0;  // reserve() discards the contents
    array.buffer.reserve(std::min<std::uint64_t>(capacity, device_.limits().tableTexels) * sizeof(T));
  }
  if (array.uploadedBytes >= bytes.size()) return;
  array.buffer.write(array.uploadedBytes, bytes.subspan(array.uploadedBytes));
  array.uploadedBytes = bytes.size();
}

// The texts of the files in the folder `shaders`; each contains the texts of the files that it includes.
extern const std::string_view kLaunchShader;
extern const std::string_view kMarchNearestShader;
extern const std::string_view kMarchListsShader;
extern const std::string_view kResolveNearestShader;
extern const std::string_view kResolveListsShader;

std::string launchShader(bool lists) {
  std::string text = glslConstant("kGroupColumns", MarchJob::kGroupColumns + 0u);
  text += fmt::format("const bool kLists = {};\n", lists) + glslConstant("kLeftToCpu", kLeftToCpu);
  return text.append(kLaunchShader);
}

std::string marchShader(bool lists) {
  std::string text = fieldConstants() + glslConstant("kLastOfList", kLastOfList) +
                     glslConstant("kMiss", static_cast<std::uint32_t>(Outcome::Miss));
  for (const auto& [name, value] : {std::pair{"kNearestLimit", kNearestLimit},
                                    {"kListLimit", kListLimit},
                                    {"kHitDistance", kHitDistance},
                                    {"kEmptyChordFactor", kEmptyChordFactor},
                                    {"kNearestChordFactor", kNearestChordFactor},
                                    {"kListChordFactor", kListChordFactor},
                                    {"kTriangleMargin", kTriangleMargin},
                                    {"kBackwardTolerance", kBackwardTolerance},
                                    {"kTieMargin", kTieMargin},
                                    {"kFaceOvershoot", kFaceOvershoot},
                                    {"kExitPlane", kExitPlane}}) {
    text += glslConstant(name, value);
  }
  return text.append(lists ? kMarchListsShader : kMarchNearestShader);
}

std::string resolveShader(bool lists) {
  std::string text = fieldConstants() + resolverConstants();
  text += glslConstant("kGroupColumns", MarchJob::kGroupColumns + 0u) + glslConstant("kLeftToCpu", kLeftToCpu) +
          glslConstant("kDone", kParticleDone) + glslConstant("kHoleSkip", kHoleSkip) +
          glslConstant("kHoleSkipShare", kHoleSkipShare);
  return text.append(lists ? kResolveListsShader : kResolveNearestShader);
}

}  // namespace scanmill
