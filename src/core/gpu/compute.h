#pragma once

// Runs compute shaders of OpenGL 4.3, without an X server. The OpenGL code is in a plug-in (gpu/compute_interface.h)
// that is loaded with the first device.

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/stage_clock.h"

namespace scanmill {

struct ComputeContext;  // what a device's buffers and programs share

// The wording of errors of a device, its buffers and its programs: "<cannot>: <why>; <instead>".
struct ComputeErrorWords {
  std::string cannot;   // "particles cannot fly by OpenGL"
  std::string instead;  // "'backend: cpu' does without it"
};

class ComputeDevice {
 public:
  // Opens the device that namedDevice() names (gpu/device.h). Throws Error if the machine has no OpenGL 4.3 with EGL,
  // or the plug-in cannot be loaded.
  explicit ComputeDevice(ComputeErrorWords words);

  const std::string& name() const;        // "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string driver() const;             // "4.5 (Core Profile) Mesa 22.3.6"
  std::string nameAndPlace() const;       // adds where software runs: "llvmpipe (...), on the processor"
  bool software() const;                  // the device is the processor
  std::uint64_t mostBufferBytes() const;  // the largest buffer that a program may read and write
  std::uint64_t mostTableTexels() const;  // the largest table, which a program only reads
  // Waits until all requested work is done.
  void finish();
  // Runs work that makes several calls of this device, its buffers and programs. All of it runs on the device's own
  // thread, so that the caller waits for that thread once.
  void atOnce(const std::function<void()>& work) const;
  // Throws an Error worded by ComputeErrorWords.
  [[noreturn]] void fail(const std::string& why) const;

 private:
  friend class ComputeBuffer;
  friend class ComputeProgram;
  friend class ComputeReadback;
  std::shared_ptr<ComputeContext> context_;
};

// A device that SCANMILL_GL_DEVICE may name (gpu/device.h).
struct FoundDevice {
  std::string name;    // value of the variable that selects it
  std::string driver;  // as ComputeDevice::name(); the reason if the device cannot compute
  bool usable = false;
  bool software = false;  // the device is the processor
};

// Returns the seconds that devices spent on each program (by its name) and on copies to the processor ("read back")
// since the last call, by the devices' own clocks. The first call starts the clocks and returns nothing.
StageSeconds takeDeviceSeconds();

// Returns the devices in the order in which they are tried. Opens each of them briefly. Throws Error if OpenGL cannot
// be loaded.
std::vector<FoundDevice> findDevices();

// Memory of a device. Buffers and programs may outlive the ComputeDevice. Calls may come from any thread, but not at
// the same time.
class ComputeBuffer {
 public:
  explicit ComputeBuffer(const ComputeDevice& device);
  ~ComputeBuffer();
  ComputeBuffer(const ComputeBuffer&) = delete;
  ComputeBuffer& operator=(const ComputeBuffer&) = delete;

  // Makes the buffer at least this large. Its contents are lost if it grows.
  void reserve(std::uint64_t bytes);
  std::uint64_t bytes() const { return bytes_; }

  // A piece of the buffer, which starts at `offset` (bytes), and the memory that it is copied from or to.
  struct Source {
    std::uint64_t offset;
    std::span<const std::byte> bytes;
  };
  struct Target {
    std::uint64_t offset;
    std::span<std::byte> bytes;
  };
  void write(std::span<const Source> pieces);
  void read(std::span<const Target> pieces) const;

  // Makes the buffer at least as large as the array, and uploads the array to its start.
  template <class T>
  void hold(std::span<const T> array) {
    reserve(array.size_bytes());
    const Source piece{0, std::as_bytes(array)};
    write({&piece, 1});
  }

 private:
  friend class ComputeProgram;
  friend class ComputeReadback;
  std::shared_ptr<ComputeContext> context_;
  std::uint32_t number_ = 0;
  std::uint64_t bytes_ = 0;
};

// Host memory to which a device copies a buffer while later programs already run. It stays mapped (OpenGL 4.4,
// ARB_buffer_storage); if the driver does not support that, start() waits for the copy.
class ComputeReadback {
 public:
  explicit ComputeReadback(const ComputeDevice& device);
  ~ComputeReadback();
  ComputeReadback(const ComputeReadback&) = delete;
  ComputeReadback& operator=(const ComputeReadback&) = delete;

  // Requests a copy of the first bytes of a buffer, as they are after all programs that were run before. Later programs
  // may write to the buffer.
  void start(const ComputeBuffer& buffer, std::uint64_t bytes);
  // Waits for the copy, which is valid until the next start(). Meanwhile other threads may use the device, or wait too.
  std::span<const std::byte> wait();

 private:
  std::shared_ptr<ComputeContext> context_;
  std::uint32_t number_ = 0;
  std::uint64_t bytes_ = 0;
  std::mutex asking_;                // only one of the waiting threads queries the device
  const std::byte* copy_ = nullptr;  // null: not complete yet
};

// A buffer that a program only reads, with texelFetch() of a usamplerBuffer (Uint16 ...) or a samplerBuffer
// (Float32x4). It is for scattered access: llvmpipe reads it a tenth to a fifth faster than a storage buffer.
struct ComputeTable {
  enum class Texel { Uint16, Uint32, Uint32x4, Float32x4 };
  const ComputeBuffer* buffer;
  Texel texel;
};

std::uint64_t texelBytes(ComputeTable::Texel texel);

// Returns the size that a table can have on the device (bytes), at most `most`.
std::uint64_t mostTableBytes(const ComputeDevice& device, ComputeTable::Texel texel, std::uint64_t most);

// Throws Error, worded by ComputeErrorWords, if `bytes` exceed mostTableBytes(): "the <what> take 3.0 MiB, of which a
// table on <device> holds 2.0 MiB<mend>".
void checkTable(const ComputeDevice& device, ComputeTable::Texel texel, std::uint64_t bytes, std::uint64_t most,
                const std::string& what, const std::string& mend = "");

// Uploads an array into the buffer of a table, after checkTable().
void holdTable(const ComputeDevice& device, ComputeBuffer& buffer, ComputeTable::Texel texel,
               std::span<const std::byte> array, std::uint64_t most, const std::string& what,
               const std::string& mend = "");

// Returns a line of GLSL that defines a constant with exactly this value, however the shader's compiler reads decimals.
std::string glslConstant(const char* name, float value);
std::string glslConstant(const char* name, std::uint32_t value);

// A pool of readbacks, for as many pieces of work as may be in flight.
class ComputeReadbacks {
 public:
  ComputeReadbacks(const ComputeDevice& device, std::size_t count);

  // Exclusive use of one readback while the lease lives. The constructor waits until a readback is free.
  class Lease {
   public:
    explicit Lease(ComputeReadbacks& all);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    ComputeReadback* operator->() const { return one_.get(); }

   private:
    ComputeReadbacks& all_;
    std::unique_ptr<ComputeReadback> one_;
  };

 private:
  std::mutex mutex_;
  std::condition_variable freed_;
  std::vector<std::unique_ptr<ComputeReadback>> free_;
};

// Returns the whole text of a compute shader: `text` as ComputeProgram takes it, the version line and main().
std::string computeShaderText(std::string_view text);

class ComputeProgram {
 public:
  // `text` is GLSL 4.30 without the version line and main(). It defines `void invoke(uint i)`, and declares storage
  // buffers (std430) of bindings 0, 1, 2 ..., samplers of bindings 0, 1, 2 ... for tables, and, if it has parameters, a
  // uniform block (std140) of binding 0. Throws Error with the compiler's message.
  ComputeProgram(const ComputeDevice& device, const std::string& name, const std::string& text);
  ~ComputeProgram();
  ComputeProgram(const ComputeProgram&) = delete;
  ComputeProgram& operator=(const ComputeProgram&) = delete;

  // Calls invoke(0) to invoke(invocations - 1) in any order; `invocations` is less than 2^32. What they write is
  // visible to the next run and to read().
  void run(std::uint64_t invocations, std::initializer_list<const ComputeBuffer*> buffers,
           std::span<const std::byte> parameters = {}, std::initializer_list<ComputeTable> tables = {});

 private:
  std::shared_ptr<ComputeContext> context_;
  std::uint32_t number_ = 0;
};

}  // namespace scanmill
