#pragma once

// Runs compute shaders of OpenGL 4.3 with ARB_buffer_storage, without an X server. All calls of OpenGL are in a plug-in
// (gpu/compute_interface.h), which is loaded when the first device is opened.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

struct ComputeContext;  // the state that a device shares with its buffers and programs

// An object of the plug-in. It is destroyed on the plug-in's thread; only the plug-in has the definition of its type.
template <class Object>
using OwnedObject = std::unique_ptr<Object, std::function<void(Object*)>>;
class GlBuffer;
class GlProgram;
class MappedCopy;

// The wording of errors of a device and of its buffers and programs. A message is "<cannot>: <reason>; <instead>".
struct ComputeErrorWords {
  std::string cannot;   // what fails without the device, such as "particles cannot fly by OpenGL"
  std::string instead;  // what the user can do instead, such as "'backend: cpu' does without it"
};

// Largest sizes that a device allows.
struct ComputeLimits {
  std::uint64_t bufferBytes = std::numeric_limits<std::uint64_t>::max();  // largest buffer that a program writes
  std::uint64_t tableTexels = std::numeric_limits<std::uint64_t>::max();  // largest table, which a program only reads
};

class ComputeDevice {
 public:
  // Opens the device that namedDevice() names (gpu/device.h). Throws Error if there is no such device, if the machine
  // has no OpenGL 4.3 with ARB_buffer_storage by EGL, or if the plug-in cannot be loaded. `extraLimits`: limits that
  // apply in addition to the device's limits.
  explicit ComputeDevice(ComputeErrorWords words, const ComputeLimits& extraLimits = {});

  const std::string& name() const;  // name of the device, such as "llvmpipe (LLVM 15.0.6, 256 bits)"
  bool software() const;            // true: a software rasteriser that runs on the CPU
  const ComputeLimits& limits() const;
  // Calls `work` on the thread that makes all calls of OpenGL. Calls of this device, its buffers and its programs in
  // `work` then do not each have to wait for that thread.
  void atOnce(const std::function<void()>& work) const;
  // Throws an Error with the wording of ComputeErrorWords. `why`: the reason in its message.
  [[noreturn]] void fail(const std::string& why) const;

 private:
  friend class ComputeBuffer;
  friend class ComputeProgram;
  friend class ComputeReadback;
  std::shared_ptr<ComputeContext> context_;
};

// An OpenGL device; the environment variable SCANMILL_GL_DEVICE can select it by its name (gpu/device.h).
struct FoundDevice {
  std::string name;    // value of the variable that selects this device
  std::string driver;  // the device's ComputeDevice::name(); if `usable` is false, why it cannot be used
  bool usable = false;
  bool software = false;  // true: runs on the CPU
};

// Opens all devices; returns them in the order in which they are tried. Throws Error if OpenGL cannot be loaded.
std::vector<FoundDevice> findDevices();

// A buffer in a device's memory; may outlive the ComputeDevice. Calls may come from any thread, but one at a time.
class ComputeBuffer {
 public:
  explicit ComputeBuffer(const ComputeDevice& device);
  ComputeBuffer& operator=(ComputeBuffer&&) = delete;  // neither copied nor moved

  // Makes the buffer at least this large. If it grows, its contents are lost.
  void reserve(std::uint64_t bytes);
  std::uint64_t bytes() const { return bytes_; }

  // Uploads `bytes` to a part of the buffer, which starts at `offset` (bytes).
  void write(std::uint64_t offset, std::span<const std::byte> bytes);

  // Uploads an array to the start of the buffer, after growing the buffer if it is too small.
  template <class T>
  void upload(std::span<const T> array) {
    reserve(array.size_bytes());
    write(0, std::as_bytes(array));
  }

 private:
  friend class ComputeProgram;
  friend class ComputeReadback;
  std::shared_ptr<ComputeContext> context_;
  OwnedObject<GlBuffer> buffer_;
  std::uint64_t bytes_ = 0;
};

// Permanently mapped host memory. A device copies a buffer into this memory, while later programs may already run.
class ComputeReadback {
 public:
  explicit ComputeReadback(const ComputeDevice& device);

  // Requests a copy of the first `bytes` bytes of a buffer, with the results of all programs that were run before.
  // Programs that are run later may already write to the buffer.
  void start(const ComputeBuffer& buffer, std::uint64_t bytes);
  // Waits for the copy and returns it. During the wait other threads may use the device, or wait for other readbacks.
  // The copy is valid until the next start().
  std::span<const std::byte> wait();

 private:
  std::shared_ptr<ComputeContext> context_;
  OwnedObject<MappedCopy> readback_;
  std::uint64_t bytes_ = 0;
  std::mutex waiting_;               // held by the thread that queries the device
  const std::byte* copy_ = nullptr;  // null: the copy is not complete yet
};

// A buffer that a program only reads, with texelFetch(), from a usamplerBuffer (Uint16, Uint32, Uint32x4) or a
// samplerBuffer (Float32x4). On llvmpipe, scattered reads are 10 to 20 % faster than from a storage buffer.
struct ComputeTable {
  enum class Texel { Uint16, Uint32, Uint32x4, Float32x4 };
  const ComputeBuffer* buffer;
  Texel texel;
};

std::uint64_t texelBytes(ComputeTable::Texel texel);

// Throws Error if a table of `bytes` bytes is larger than the device allows. The message is worded by the device's
// ComputeErrorWords; its reason is "the <contents> take 3.0 MiB, of which a table on <device> holds 2.0 MiB<remedy>".
void checkTable(const ComputeDevice& device, ComputeTable::Texel texel, std::uint64_t bytes,
                const std::string& contents, const std::string& remedy = "");

// Calls checkTable() for an array, then uploads the array into a table's buffer.
void uploadTable(const ComputeDevice& device, ComputeBuffer& buffer, ComputeTable::Texel texel,
                 std::span<const std::byte> array, const std::string& contents, const std::string& remedy = "");

// Returns a line of GLSL that defines a constant with exactly this value. The value is given by its bits, since shader
// compilers may round decimals differently.
std::string glslConstant(const char* name, float value);
std::string glslConstant(const char* name, std::uint32_t value);

// Returns the complete text of a compute shader: the version line, `text` (see ComputeProgram) and main().
std::string computeShaderText(std::string_view text);

class ComputeProgram {
 public:
  // Compiles a program. `text`: GLSL 4.30 without the version line and main(). It must define `void invoke(uint i)`,
  // and declare its storage buffers (std430) with bindings 0, 1, 2 ..., the samplers of its tables with bindings 0, 1,
  // 2 ... and its parameters, if any, as a uniform block (std140) with binding 0. Throws Error if compiling fails.
  ComputeProgram(const ComputeDevice& device, const std::string& name, const std::string& text);
  ComputeProgram& operator=(ComputeProgram&&) = delete;  // neither copied nor moved

  // Calls invoke(i) for i from 0 to invocations - 1, in any order; `invocations` must be less than 2^32. The data that
  // these calls write is visible to the next run() and to readbacks. Limit: 8 buffers, 16 tables, 16 KiB of parameters.
  void run(std::uint64_t invocations, std::initializer_list<const ComputeBuffer*> buffers,
           std::span<const std::byte> parameters = {}, std::initializer_list<ComputeTable> tables = {});

 private:
  std::shared_ptr<ComputeContext> context_;
  OwnedObject<GlProgram> program_;
};

}  // namespace scanmill
