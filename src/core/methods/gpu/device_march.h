#pragma once

// Marches particles on a device, through fields that stay on the device between calls.

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "gpu/compute.h"
#include "methods/field/distance_field.h"
#include "methods/world/world.h"

namespace scanmill {

constexpr float kLeftToCpu = -1;  // value of Particles::begin that leaves a particle to the CPU

// Values of the outcome column of hit records, in addition to the values of Outcome.
constexpr std::uint32_t kPassesHole = 3;              // the particle continues behind a hole
constexpr std::uint32_t kParticleDone = 0x80000000u;  // flag: the particle's result is complete

// The compute programs of particles are assembled from the files in methods/gpu/shaders and the constants that the
// CPU's code uses. A comment at the top of each file lists the program's buffers and tables. See gpu/compute.h.
// kRaysShader is the text of rays.glsl alone, for other programs that need the rays of shots.
extern const std::string_view kRaysShader;

// Return the texts of programs for fields with or without lists of triangles. The launch program creates particles, the
// march program takes the particles' steps, and the resolve program computes hits from hit records.
std::string launchShader(bool lists);
std::string marchShader(bool lists);
std::string resolveShader(bool lists);

// Distance fields on a device. When a field moves with its sensor, the field at the new position shares a pool of
// bricks with the field at the previous position (BrickPool). Only bricks that are not on the device yet are uploaded.
class DeviceFields {
 public:
  explicit DeviceFields(const ComputeDevice& device) : device_(device) {}

  // Uploads the parts of the field that are not on the device yet. The pools of earlier fields stay on the device, for
  // threads that work on other trajectories. If a new pool would probably bring the total above kMostBytes, the pool
  // replaces the least recently used pool; if memory runs out, all other pools are dropped. If the field still does not
  // fit, throws Error (see ComputeErrorWords).
  void ensureUploaded(const std::shared_ptr<const DistanceField>& field);

  // The tables of the field that was uploaded last. levels() has two words of 16 bytes per level. The first word has
  // the bits of the level's offset (float32) and the index of the level's first entry in the table; the second word has
  // the level's numbers of bricks along x, y and z.
  ComputeTable levels() const { return {&pools_.front().levels, ComputeTable::Texel::Uint32x4}; }
  ComputeTable table() const { return {&pools_.front().table, ComputeTable::Texel::Uint32}; }
  ComputeTable distances() const { return {&pools_.front().distances.buffer, ComputeTable::Texel::Uint16}; }
  ComputeTable trianglesOrLists() const {
    return {&pools_.front().trianglesOrLists.buffer, ComputeTable::Texel::Uint32};
  }
  ComputeTable lists() const { return {&pools_.front().lists.buffer, ComputeTable::Texel::Uint32}; }

 private:
  static constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;

  // An array of a pool, whose first `uploadedBytes` bytes are uploaded.
  struct Array {
    ComputeBuffer buffer;
    std::uint64_t uploadedBytes = 0;  // number of uploaded bytes
  };

  // A pool on the device. `field`: the pool's field that was uploaded last.
  struct UploadedPool {
    explicit UploadedPool(const ComputeDevice& device);
    std::uint64_t bytes() const;

    std::weak_ptr<const BrickPool> pool;
    std::weak_ptr<const DistanceField> field;
    ComputeBuffer levels, table;
    Array distances, trianglesOrLists, lists;
  };

  void bringToFront(const std::shared_ptr<const BrickPool>& pool);
  void upload(const std::shared_ptr<const DistanceField>& field);
  template <class T>
  void append(Array& array, ComputeTable::Texel texel, std::span<const T> elements, std::size_t capacity,
              const char* contents);

  ComputeDevice device_;
  std::list<UploadedPool> pools_;  // most recently used first
};

// A program in two variants, for fields without and with lists. A variant is compiled when it is first needed.
class MarchPrograms {
 public:
  MarchPrograms(const ComputeDevice& device, const char* name, std::string (*shader)(bool lists))
      : device_(device), name_(name), shader_(shader) {}
  ComputeProgram& of(bool lists) {
    std::unique_ptr<ComputeProgram>& program = programs_[lists ? 1 : 0];
    if (program == nullptr) program = std::make_unique<ComputeProgram>(device_, name_, shader_(lists));
    return *program;
  }

 private:
  ComputeDevice device_;
  const char* name_;
  std::string (*shader_)(bool lists);
  std::array<std::unique_ptr<ComputeProgram>, 2> programs_;
};

class DeviceMarch {
 public:
  explicit DeviceMarch(const ComputeDevice& device);

  // Number of float32 columns of the particles: kMostColumns in fields with lists, kFewestColumns in fields without.
  static constexpr std::uint64_t kMostColumns = 14;
  static constexpr std::uint64_t kFewestColumns = 8;

  // Uploads the parts of a field that are not on the device yet. If the field has lists, also uploads the world's
  // triangles, unless they are on the device. Throws Error (see ComputeErrorWords) if something does not fit.
  void ensureUploaded(const std::shared_ptr<const DistanceField>& field, const std::shared_ptr<const World>& world);

  enum class Marching { All, BehindHoles };  // all particles, or only those that continue behind a hole

  // Reserves memory for particles and their records. run() marches these particles through `field`, uploaded last.
  void reserve(bool lists, std::size_t particles);
  void run(const DistanceField& field, std::uint32_t maxSteps, std::size_t particles, Marching which);

  // Return the buffers for the bindings 0 and 1 of marchShader(), and the fields on the device.
  ComputeBuffer& particles() { return particles_; }
  const ComputeBuffer& records() const { return records_; }
  const DeviceFields& fields() const { return fields_; }

 private:
  ComputeDevice device_;
  MarchPrograms marchers_;
  ComputeBuffer particles_, records_, triangles_;
  DeviceFields fields_;
  std::weak_ptr<const World> world_;  // the world whose triangles are uploaded
};

}  // namespace scanmill
