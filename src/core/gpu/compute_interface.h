#pragma once

// The interface of the plug-in libscanmill_gpu.so (base/module.h), through which gpu/compute.h runs compute shaders.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/module.h"
#include "gpu/compute.h"

namespace scanmill {

constexpr std::uint32_t kComputeGroup = 64;  // invocations of a shader that form a group
// Locations of two uniforms: the index of a dispatch's first invocation, and the index of its last invocation plus 1.
constexpr std::int32_t kFirstInvocation = 0;
constexpr std::int32_t kEndInvocation = 1;

// One run of a program.
struct ComputeRun {
  struct Table {
    const GlBuffer* buffer;
    ComputeTable::Texel texel;
  };
  const GlProgram& program;
  std::span<const GlBuffer* const> buffers;  // buffers[k] becomes the storage buffer with binding k
  std::span<const Table> tables;             // tables[k] becomes the buffer texture with binding k
  std::span<const std::byte> parameters;     // contents of the uniform block with binding 0, in std140 layout
  std::uint64_t invocations;                 // less than 2^32
};

// A device with its own OpenGL context. Calls may come from any thread, but not at the same time. They throw
// std::bad_alloc if the device's memory is exhausted, and std::runtime_error for other errors.
class ComputeBackend {
 public:
  virtual ~ComputeBackend() = default;
  virtual std::string name() const = 0;
  virtual bool software() const = 0;  // true: runs on the CPU
  virtual ComputeLimits limits() const = 0;
  // Compiles a program. `text`: see ComputeProgram's constructor. All objects must be destroyed before the backend.
  virtual OwnedObject<GlProgram> makeProgram(const std::string& name, const std::string& text) = 0;
  virtual OwnedObject<GlBuffer> makeBuffer() = 0;
  // Gives the buffer this size (bytes). Its contents are undefined afterwards.
  virtual void resize(GlBuffer& buffer, std::uint64_t bytes) = 0;
  virtual void write(GlBuffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes) = 0;
  // Creates the host memory of a ComputeReadback.
  virtual OwnedObject<MappedCopy> makeReadback() = 0;
  virtual void startCopy(MappedCopy& readback, const GlBuffer& buffer, std::uint64_t bytes) = 0;
  // Returns the readback's copy; null if it is not complete yet.
  virtual const std::byte* copied(MappedCopy& readback) = 0;
  // Calls the program's invoke() for 0 to invocations - 1. Later runs and reads see the data that invoke() has written.
  virtual void run(const ComputeRun& run) = 0;
  // Calls `work` on the OpenGL thread, so that calls of this backend in `work` do not each switch threads.
  virtual void atOnce(const std::function<void()>& work) = 0;
};

class ComputeModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_gpu.so", "nothing can be computed by OpenGL",
                                    "install GLEW and EGL (on Debian the packages libglew-dev and libegl-dev)"};
  virtual ~ComputeModule() = default;
  // Opens a device. `device`: the result of namedDevice(). Throws NoDevice if no device is suitable, and
  // std::invalid_argument if no device has this name.
  virtual std::unique_ptr<ComputeBackend> open(const std::string& device) const = 0;
  // Returns the names of all devices, as namedDevice() can return them, in the order in which open() tries them.
  virtual std::vector<std::string> devices() const = 0;
};

}  // namespace scanmill
