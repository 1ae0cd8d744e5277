// The plug-in libscanmill_gpu.so: runs compute shaders in an OpenGL context that it creates, with the interface of
// gpu/compute_interface.h. The only part of VTK that it needs is VTK's GLEW.

#include <vtk_glew.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "gpu/compute_interface.h"
#include "gpu/device.h"
#include "gpu/opengl_module/egl_context.h"
#include "gpu/opengl_module/gl_objects.h"
#include "gpu/opengl_module/gl_thread.h"

namespace scanmill {

// Host memory into which the device copies a buffer.
class MappedCopy {
 public:
  MappedCopy() = default;
  ~MappedCopy() { drop(); }
  MappedCopy& operator=(MappedCopy&&) = delete;  // neither copied nor moved

  void start(GLuint buffer, std::size_t bytes) {
    glBindBuffer(GL_COPY_READ_BUFFER, buffer);
    if (bytes > bytes_) map(bytes);
    glBindBuffer(GL_COPY_WRITE_BUFFER, name_);
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, static_cast<GLsizeiptr>(bytes));
    glDeleteSync(fence_);
    fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
    checkGl("a buffer cannot be copied");
  }

  // Returns the copy; null if it is not complete yet.
  const std::byte* copied() {
    if (fence_ == nullptr) return memory_;
    const GLenum state = glClientWaitSync(fence_, 0, 0);
    checkGl("the device failed");
    if (state == GL_TIMEOUT_EXPIRED) return nullptr;
    if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED) throw std::runtime_error("the device failed");
    glDeleteSync(fence_);
    fence_ = nullptr;
    return memory_;
  }

 private:
  // Frees the mapped memory, and maps `bytes` bytes of new memory.
  void map(std::size_t bytes) {
    drop();
    constexpr GLbitfield kAccess = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    glGenBuffers(1, &name_);
    glBindBuffer(GL_COPY_WRITE_BUFFER, name_);
    glBufferStorage(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, kAccess | GL_CLIENT_STORAGE_BIT);
    memory_ = static_cast<const std::byte*>(
        glMapBufferRange(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), kAccess));
    checkGl("a buffer cannot be mapped");
    if (memory_ == nullptr) throw std::bad_alloc();
    bytes_ = bytes;
  }

  void drop() {
    glDeleteSync(fence_);
    glDeleteBuffers(1, &name_);
    fence_ = nullptr;
    name_ = 0;
    memory_ = nullptr;
    bytes_ = 0;
  }

  GLuint name_ = 0;
  std::size_t bytes_ = 0;
  const std::byte* memory_ = nullptr;
  GLsync fence_ = nullptr;
};

namespace {

// Loads OpenGL's functions. Throws NoDevice if some are missing. GLEW's error without an X display is ignored.
void findFunctions() {
  glewExperimental = GL_TRUE;
  glewInit();
  while (glGetError() != GL_NO_ERROR) continue;
  if (!GLEW_VERSION_4_3) throw NoDevice("its functions are not those of OpenGL 4.3");
  // Testing GLEW_ARB_buffer_storage does not suffice: GLEW also sets it if a driver has only the extension's functions.
  if (!glewGetExtension("GL_ARB_buffer_storage")) throw NoDevice("it lacks ARB_buffer_storage");
}

std::string textOf(GLenum name, const char* unknown) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text != nullptr ? text : unknown;
}

// True for Mesa's software rasterisers and for the software rasteriser of Windows, which Mesa can use.
bool isSoftware(std::string_view renderer) {
  return std::ranges::any_of(
      std::initializer_list<std::string_view>{"llvmpipe", "softpipe", "SWR", "swrast", "Software", "Basic Render"},
      [&](std::string_view name) { return renderer.find(name) != std::string_view::npos; });
}

std::uint64_t limitOf(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return static_cast<std::uint64_t>(std::max<GLint64>(value, 0));
}

// Returns the largest number of work groups of a dispatch. The software rasteriser llvmpipe divides a dispatch among
// its threads in advance, one contiguous part for each, so only small dispatches keep all threads busy until the end.
std::uint64_t groupsPerDispatch(bool software) {
  constexpr GLint kGuaranteed = 65535;            // OpenGL guarantees this number
  constexpr std::uint64_t kGroupsPerThread = 64;  // so few that all threads end at about the same time
  GLint reported = 0;
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &reported);
  const auto most = static_cast<std::uint64_t>(std::max(reported, kGuaranteed));
  const std::uint64_t threads = std::max(std::thread::hardware_concurrency(), 1u);
  return software ? std::min(most, kGroupsPerThread * threads) : most;
}

constexpr GLenum kTexelFormats[] = {GL_R16UI, GL_R32UI, GL_RGBA32UI, GL_RGBA32F};  // by ComputeTable::Texel

// A texture through which shaders read a buffer.
class BufferTexture {
 public:
  BufferTexture() { glGenTextures(1, &name_); }
  ~BufferTexture() { glDeleteTextures(1, &name_); }
  BufferTexture& operator=(BufferTexture&&) = delete;  // neither copied nor moved

  void bind(GLuint unit, GLuint buffer, GLenum format) const {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_BUFFER, name_);
    glTexBuffer(GL_TEXTURE_BUFFER, format, buffer);
  }

 private:
  GLuint name_ = 0;
};

// An OpenGL context, and its objects that each run uses.
struct ContextState {
  explicit ContextState(const std::string& device) : context(device) {
    findFunctions();
    parameters = std::make_unique<GlBuffer>();
  }

  EglContext context;
  std::unique_ptr<GlBuffer> parameters;
  std::vector<std::unique_ptr<BufferTexture>> textures;  // indexed by binding
};

class GlCompute final : public ComputeBackend {
 public:
  explicit GlCompute(const std::string& device) {
    thread_->run([&] {
      auto state = std::make_unique<ContextState>(device);
      name_ = textOf(GL_RENDERER, "an unknown device");
      software_ = isSoftware(name_);
      groupsPerDispatch_ = groupsPerDispatch(software_);
      limits_ = {limitOf(GL_MAX_SHADER_STORAGE_BLOCK_SIZE), limitOf(GL_MAX_TEXTURE_BUFFER_SIZE)};
      checkGl("the device cannot be asked for its limits");
      state_ = std::move(state);
    });
  }

  ~GlCompute() override {
    thread_->run([&]() noexcept {
      state_->context.tryMakeCurrent();
      state_.reset();
    });
  }
  GlCompute& operator=(GlCompute&&) = delete;  // neither copied nor moved

  std::string name() const override { return name_; }
  bool software() const override { return software_; }
  ComputeLimits limits() const override { return limits_; }

  OwnedObject<GlProgram> makeProgram(const std::string& name, const std::string& text) override {
    return makeOwned<GlProgram>(name, std::initializer_list<GlShaderText>{{GL_COMPUTE_SHADER, text.c_str()}});
  }
  OwnedObject<GlBuffer> makeBuffer() override { return makeOwned<GlBuffer>(); }
  OwnedObject<MappedCopy> makeReadback() override { return makeOwned<MappedCopy>(); }

  void startCopy(MappedCopy& readback, const GlBuffer& buffer, std::uint64_t bytes) override {
    withContext([&](ContextState&) { readback.start(buffer.name(), bytes); });
  }

  const std::byte* copied(MappedCopy& readback) override {
    const std::byte* copy = nullptr;
    withContext([&](ContextState&) { copy = readback.copied(); });
    return copy;
  }

  void atOnce(const std::function<void()>& work) override { thread_->run(work); }

  // The usage hint asks for device memory, since compute shaders access buffers more often than the CPU does.
  void resize(GlBuffer& buffer, std::uint64_t bytes) override {
    withContext([&](ContextState&) {
      buffer.fill(nullptr, bytes, GL_DYNAMIC_COPY);
      checkGl("a buffer cannot be made");
    });
  }

  void write(GlBuffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes) override {
    withContext([&](ContextState&) {
      glBindBuffer(GL_COPY_WRITE_BUFFER, buffer.name());
      glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes.size()),
                      bytes.data());
      checkGl("a buffer cannot be written");
    });
  }

  void run(const ComputeRun& run) override {
    withContext([&](ContextState& state) {
      run.program.use();
      for (GLuint k = 0; k < run.buffers.size(); ++k) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, k, run.buffers[k]->name());
      }
      while (state.textures.size() < run.tables.size()) state.textures.push_back(std::make_unique<BufferTexture>());
      for (GLuint k = 0; k < run.tables.size(); ++k) {
        state.textures[k]->bind(k, run.tables[k].buffer->name(),
                                kTexelFormats[static_cast<std::size_t>(run.tables[k].texel)]);
      }
      if (!run.parameters.empty()) {
        state.parameters->fill(run.parameters.data(), run.parameters.size(), GL_STREAM_DRAW);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, state.parameters->name());
      }
      const std::uint64_t mostAtOnce = groupsPerDispatch_ * kComputeGroup;  // invocations per dispatch
      for (std::uint64_t first = 0; first < run.invocations; first += mostAtOnce) {
        const std::uint64_t end = std::min(first + mostAtOnce, run.invocations);
        glUniform1ui(kFirstInvocation, static_cast<GLuint>(first));
        glUniform1ui(kEndInvocation, static_cast<GLuint>(end));
        glDispatchCompute(static_cast<GLuint>((end - first + kComputeGroup - 1) / kComputeGroup), 1, 1);
      }
      glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
      glUseProgram(0);
      checkGl("a program cannot be run");
    });
  }

 private:
  // Makes the context current on the OpenGL thread, and calls `work` with it there.
  template <class Work>
  void withContext(const Work& work) {
    thread_->run([&] {
      state_->context.makeCurrent();
      work(*state_);
    });
  }

  // Returns an object that is created and destroyed on the OpenGL thread while the context is current.
  template <class Object, class... Arguments>
  OwnedObject<Object> makeOwned(const Arguments&... arguments) {
    std::unique_ptr<Object> object;
    withContext([&](ContextState&) { object = std::make_unique<Object>(arguments...); });
    return {object.release(), [this](Object* owned) {
              thread_->run([&]() noexcept {
                state_->context.tryMakeCurrent();
                delete owned;
              });
            }};
  }

  std::shared_ptr<GlThread> thread_ = GlThread::shared();
  std::unique_ptr<ContextState> state_;
  std::string name_;
  bool software_ = false;
  ComputeLimits limits_;
  std::uint64_t groupsPerDispatch_ = 0;  // largest number of work groups of a dispatch
};

class GlComputeModule final : public ComputeModule {
 public:
  std::unique_ptr<ComputeBackend> open(const std::string& device) const override {
    return std::make_unique<GlCompute>(device);
  }
  std::vector<std::string> devices() const override { return eglDevices(); }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(ComputeModule, GlComputeModule)
