#pragma once

// The interface of libscanmill_gpu.so, which computes by compute shaders (base/module.h). Programs use gpu/compute.h.

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

struct ComputeLimits {
  std::uint64_t bufferBytes = 0;     // of a buffer that a program reads or writes
  std::uint64_t tableTexels = 0;     // of a table
  std::uint64_t parameterBytes = 0;  // of a program's parameters
  std::uint32_t buffers = 0;         // that a program reads or writes
  std::uint32_t tables = 0;          // that a program reads
};

// Programs and buffers are numbers that the backend gives out, none of them 0.
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

// A device with a context of its own. Calls may come from any thread, one after the other. They throw std::bad_alloc
// where the device's memory is out, and std::runtime_error.
class ComputeBackend {
 public:
  virtual ~ComputeBackend() = default;
  virtual std::string name() const = 0;
  virtual std::string driver() const = 0;
  virtual bool software() const = 0;  // it runs on the processor
  virtual ComputeLimits limits() const = 0;
  // `text` is as ComputeProgram takes it.
  virtual std::uint32_t makeProgram(const std::string& name, const std::string& text) = 0;
  virtual std::uint32_t makeBuffer() = 0;
  virtual void dropProgram(std::uint32_t program) noexcept = 0;
  virtual void dropBuffer(std::uint32_t buffer) noexcept = 0;
  // Gives the buffer so many bytes, of any contents.
  virtual void resize(std::uint32_t buffer, std::uint64_t bytes) = 0;
  virtual void write(std::uint32_t buffer, std::span<const ComputeBuffer::Source> pieces) = 0;
  virtual void read(std::uint32_t buffer, std::span<const ComputeBuffer::Target> pieces) = 0;
  // Memory of the processor that a device copies to, by the number that it gives out: see ComputeReadback.
  virtual std::uint32_t makeReadback() = 0;
  virtual void dropReadback(std::uint32_t readback) noexcept = 0;
  virtual void startCopy(std::uint32_t readback, std::uint32_t buffer, std::uint64_t bytes) = 0;
  // The copy, or null while it is not there.
  virtual const std::byte* copied(std::uint32_t readback) = 0;
  // Runs invoke() for 0 to invocations - 1. What is written shows in later runs and reads.
  virtual void run(const ComputeRun& run) = 0;
  // Waits until everything asked for is done.
  virtual void finish() = 0;
  // Does work that makes several of these calls without a change of threads between them.
  virtual void atOnce(const std::function<void()>& work) = 0;
};

class ComputeModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_gpu.so", "nothing can be computed by OpenGL",
                                    "install GLEW and EGL (on Debian the packages libglew-dev and libegl-dev)"};
  virtual ~ComputeModule() = default;
  // `device` is as namedDevice() gives it. Throws NoDevice, and std::invalid_argument where there is none of that name.
  virtual std::unique_ptr<ComputeBackend> open(const std::string& device) const = 0;
  // What namedDevice() may name, in the order in which open() tries them.
  virtual std::vector<std::string> devices() const = 0;
  // See takeDeviceSeconds().
  virtual StageSeconds takeSeconds() const = 0;
};

}  // namespace scanmill
