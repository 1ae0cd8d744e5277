#pragma once

// The interface of the plug-in libscanmill_gpu.so, which runs compute shaders (base/module.h). Other code uses
// gpu/compute.h.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/module.h"
#include "base/stage_clock.h"
#include "gpu/compute.h"

namespace scanmill {

constexpr std::uint32_t kComputeGroup = 64;   // invocations of a shader that form a group
constexpr std::int32_t kFirstInvocation = 0;  // location of a shader's uniform: the first invocation of a dispatch
constexpr std::int32_t kEndInvocation = 1;    // location of a shader's uniform: one after the last invocation

struct ComputeLimits {
  std::uint64_t bufferBytes = 0;     // the largest buffer that a program reads or writes
  std::uint64_t tableTexels = 0;     // the largest table
  std::uint64_t parameterBytes = 0;  // the most parameters of a program
  std::uint32_t buffers = 0;         // number of buffers that a program reads or writes
  std::uint32_t tables = 0;          // number of tables that a program reads
};

// One run of a program. Programs and buffers are identified by numbers that the backend assigns, never 0.
struct ComputeRun {
  struct Table {
    std::uint32_t buffer;
    ComputeTable::Texel texel;
  };
  std::uint32_t program = 0;
  std::span<const std::uint32_t> buffers;  // number k becomes the storage buffer of binding k
  std::span<const Table> tables;           // number k becomes the buffer texture of binding k
  std::span<const std::byte> parameters;   // the uniform block of binding 0, laid out by std140
  std::uint64_t invocations = 0;           // less than 2^32
};

// A device with a context of its own. Calls may come from any thread, but not at the same time. They throw
// std::bad_alloc if the device's memory is exhausted, and std::runtime_error for other errors.
class ComputeBackend {
 public:
  virtual ~ComputeBackend() = default;
  virtual std::string name() const = 0;
  virtual std::string driver() const = 0;
  virtual bool software() const = 0;  // the device is the processor
  virtual ComputeLimits limits() const = 0;
  // `text`: a whole compute shader, as computeShaderText() returns it.
  virtual std::uint32_t makeProgram(const std::string& name, const std::string& text) = 0;
  virtual std::uint32_t makeBuffer() = 0;
  virtual void dropProgram(std::uint32_t program) noexcept = 0;
  virtual void dropBuffer(std::uint32_t buffer) noexcept = 0;
  // Gives the buffer this size; its contents are then undefined.
  virtual void resize(std::uint32_t buffer, std::uint64_t bytes) = 0;
  virtual void write(std::uint32_t buffer, std::span<const ComputeBuffer::Source> pieces) = 0;
  virtual void read(std::uint32_t buffer, std::span<const ComputeBuffer::Target> pieces) = 0;
  // Creates host memory to which the device copies, and returns its number: see ComputeReadback.
  virtual std::uint32_t makeReadback() = 0;
  virtual void dropReadback(std::uint32_t readback) noexcept = 0;
  virtual void startCopy(std::uint32_t readback, std::uint32_t buffer, std::uint64_t bytes) = 0;
  // Returns the copy, or null while it is not complete.
  virtual const std::byte* copied(std::uint32_t readback) = 0;
  // Runs invoke() for 0 to invocations - 1. What it writes is visible to later runs and reads.
  virtual void run(const ComputeRun& run) = 0;
  // Waits until all requested work is done.
  virtual void finish() = 0;
  // Runs work that makes several of these calls, without a change of threads between them.
  virtual void atOnce(const std::function<void()>& work) = 0;
};

class ComputeModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_gpu.so", "nothing can be computed by OpenGL",
                                    "install GLEW and EGL (on Debian the packages libglew-dev and libegl-dev)"};
  virtual ~ComputeModule() = default;
  // `device`: as namedDevice() returns it. Throws NoDevice, and std::invalid_argument if no device has that name.
  virtual std::unique_ptr<ComputeBackend> open(const std::string& device) const = 0;
  // Returns the names that namedDevice() may give, in the order in which open() tries the devices.
  virtual std::vector<std::string> devices() const = 0;
  // See takeDeviceSeconds().
  virtual StageSeconds takeSeconds() const = 0;
};

}  // namespace scanmill
