#include "passes/vtk_module/gl_compute.h"

#include <fmt/format.h>
#include <vtk_glew.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "passes/vtk_module/egl_context.h"
#include "passes/vtk_module/gl_objects.h"
#include "passes/vtk_module/gl_thread.h"
#include "passes/vtk_module/guarded.h"

namespace scanmill {

namespace {

constexpr std::uint64_t kGroup = 64;
constexpr GLint kFirst = 0;  // locations of the uniforms
constexpr GLint kEnd = 1;

constexpr const char* kBefore = R"(#version 430 core
layout(local_size_x = 64) in;
layout(location = 0) uniform uint firstInvocation;
layout(location = 1) uniform uint endInvocation;
#line 1
)";

// Numbers are compared with what is left, for a sum could overflow.
constexpr const char* kAfter = R"(
void main() {
  if (gl_GlobalInvocationID.x < endInvocation - firstInvocation) invoke(firstInvocation + gl_GlobalInvocationID.x);
}
)";

// GLEW finds OpenGL's functions, then asks for an X display and calls it an error where it finds none.
void findFunctions() {
  glewExperimental = GL_TRUE;
  glewInit();
  while (glGetError() != GL_NO_ERROR) continue;
  if (!GLEW_VERSION_4_3) throw NoDevice("its functions are not those of OpenGL 4.3");
}

std::string rendererName() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name != nullptr ? name : "an unknown device";
}

// Mesa's rasterisers on the processor, and Windows' by way of Mesa.
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

// Of one dispatch. Mesa's llvmpipe gives each of its threads one contiguous part of a dispatch, however long that
// takes: small dispatches, of elements that are alike, keep all of them busy.
std::uint64_t groupsAtOnce(bool software) {
  GLint most = 0;
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &most);
  const auto promised = static_cast<std::uint64_t>(std::max(most, 65535));
  constexpr std::uint64_t kGroupsPerThread = 64;
  const std::uint64_t threads = std::max(std::thread::hardware_concurrency(), 1u);
  return software ? std::min(promised, kGroupsPerThread * threads) : promised;
}

GLenum formatOf(ScanmillComputeTexel texel) {
  switch (texel) {
    case kScanmillUint16:
      return GL_R16UI;
    case kScanmillUint32:
      return GL_R32UI;
    case kScanmillUint32x4:
      return GL_RGBA32UI;
    case kScanmillFloat32x4:
      break;
  }
  return GL_RGBA32F;
}

}  // namespace

class BufferTexture {
 public:
  BufferTexture() { glGenTextures(1, &name_); }
  ~BufferTexture() { glDeleteTextures(1, &name_); }
  BufferTexture(const BufferTexture&) = delete;
  BufferTexture& operator=(const BufferTexture&) = delete;

  void show(GLuint unit, GLuint buffer, GLenum format) const {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_BUFFER, name_);
    glTexBuffer(GL_TEXTURE_BUFFER, format, buffer);
  }

 private:
  GLuint name_ = 0;
};

}  // namespace scanmill

struct ScanmillCompute {
  explicit ScanmillCompute(const std::string& device) : context(device) { scanmill::findFunctions(); }

  std::shared_ptr<scanmill::GlThread> thread;
  scanmill::EglContext context;
  std::map<std::uint32_t, std::unique_ptr<scanmill::GlProgram>> programs;
  std::map<std::uint32_t, std::unique_ptr<scanmill::GlBuffer>> buffers;
  std::uint32_t lastNumber = 0;
  std::unique_ptr<scanmill::GlBuffer> parameters;
  std::vector<std::unique_ptr<scanmill::BufferTexture>> textures;  // by binding
  std::uint64_t groups = 0;                                        // in one dispatch
};

namespace scanmill {

namespace {

template <class Work>
ScanmillVtkStatus withContext(ScanmillCompute& compute, ScanmillVtkText& error, const Work& work) noexcept {
  return guarded(*compute.thread, error, [&] {
    compute.context.makeCurrent();
    try {
      work();
    } catch (...) {
      compute.context.release();
      throw;
    }
    compute.context.release();
  });
}

ScanmillVtkStatus open(const char* device, ScanmillCompute** compute, ScanmillComputeLimits* limits,
                       ScanmillVtkText* described, ScanmillVtkText* error) {
  std::shared_ptr<GlThread> thread;
  try {
    thread = GlThread::shared();
  } catch (const std::exception& e) {  // no thread to be had
    put(*error, e.what());
    return kScanmillVtkFailed;
  }
  return guarded(*thread, *error, [&] {
    auto opened = std::make_unique<ScanmillCompute>(device != nullptr ? device : "");
    opened->thread = thread;
    opened->parameters = std::make_unique<GlBuffer>();
    const std::string name = rendererName();
    const bool software = isSoftware(name);
    opened->groups = groupsAtOnce(software);
    *limits = {limitOf(GL_MAX_SHADER_STORAGE_BLOCK_SIZE),
               limitOf(GL_MAX_TEXTURE_BUFFER_SIZE),
               limitOf(GL_MAX_UNIFORM_BLOCK_SIZE),
               static_cast<std::uint32_t>(limitOf(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS)),
               static_cast<std::uint32_t>(limitOf(GL_MAX_COMPUTE_TEXTURE_IMAGE_UNITS)),
               software ? 1u : 0u,
               0};
    put(*described, name);
    checkGl("the device cannot be asked for its limits");
    opened->context.release();
    *compute = opened.release();
  });
}

void close(ScanmillCompute* compute) {
  const std::shared_ptr<GlThread> thread = compute->thread;  // outlives it: a thread cannot end itself
  ScanmillVtkText ignored;
  guarded(*thread, ignored, [&] {
    const std::unique_ptr<ScanmillCompute> closed(compute);
    closed->context.makeCurrent();
  });
}

ScanmillVtkStatus makeProgram(ScanmillCompute* compute, const char* name, const char* text, std::uint32_t* program,
                              ScanmillVtkText* error) {
  return withContext(*compute, *error, [&] {
    const std::string whole = std::string(kBefore) + text + kAfter;
    auto made =
        std::make_unique<GlProgram>(name, std::initializer_list<GlShaderText>{{GL_COMPUTE_SHADER, whole.c_str()}});
    *program = ++compute->lastNumber;
    compute->programs[*program] = std::move(made);
  });
}

ScanmillVtkStatus makeBuffer(ScanmillCompute* compute, std::uint32_t* buffer, ScanmillVtkText* error) {
  return withContext(*compute, *error, [&] {
    auto made = std::make_unique<GlBuffer>();
    *buffer = ++compute->lastNumber;
    compute->buffers[*buffer] = std::move(made);
  });
}

void dropProgram(ScanmillCompute* compute, std::uint32_t program) {
  ScanmillVtkText ignored;
  withContext(*compute, ignored, [&] { compute->programs.erase(program); });
}

void dropBuffer(ScanmillCompute* compute, std::uint32_t buffer) {
  ScanmillVtkText ignored;
  withContext(*compute, ignored, [&] { compute->buffers.erase(buffer); });
}

// Memory of the device is asked for: programs, not the processor, read and write most.
ScanmillVtkStatus resize(ScanmillCompute* compute, std::uint32_t buffer, std::uint64_t bytes, ScanmillVtkText* error) {
  return withContext(*compute, *error, [&] {
    compute->buffers.at(buffer)->fill(nullptr, bytes, GL_DYNAMIC_COPY);
    checkGl("a buffer cannot be made");
  });
}

ScanmillVtkStatus write(ScanmillCompute* compute, std::uint32_t buffer, const ScanmillComputeSource* pieces,
                        std::uint64_t count, ScanmillVtkText* error) {
  return withContext(*compute, *error, [&] {
    glBindBuffer(GL_COPY_WRITE_BUFFER, compute->buffers.at(buffer)->name());
    for (std::uint64_t k = 0; k < count; ++k) {
      glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(pieces[k].offset),
                      static_cast<GLsizeiptr>(pieces[k].bytes), pieces[k].data);
    }
    checkGl("a buffer cannot be written");
  });
}

ScanmillVtkStatus read(ScanmillCompute* compute, std::uint32_t buffer, const ScanmillComputeTarget* pieces,
                       std::uint64_t count, ScanmillVtkText* error) {
  return withContext(*compute, *error, [&] {
    glBindBuffer(GL_COPY_READ_BUFFER, compute->buffers.at(buffer)->name());
    for (std::uint64_t k = 0; k < count; ++k) {
      glGetBufferSubData(GL_COPY_READ_BUFFER, static_cast<GLintptr>(pieces[k].offset),
                         static_cast<GLsizeiptr>(pieces[k].bytes), pieces[k].data);
    }
    checkGl("a buffer cannot be read back");
  });
}

ScanmillVtkStatus run(ScanmillCompute* compute, const ScanmillComputeRun* run, ScanmillVtkText* error) {
  return withContext(*compute, *error, [&] {
    compute->programs.at(run->program)->use();
    for (std::uint32_t k = 0; k < run->bufferCount; ++k) {
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, k, compute->buffers.at(run->buffers[k])->name());
    }
    while (compute->textures.size() < run->tableCount) {
      compute->textures.push_back(std::make_unique<BufferTexture>());
    }
    for (GLuint k = 0; k < run->tableCount; ++k) {
      const ScanmillComputeTable& table = run->tables[k];
      compute->textures[k]->show(k, compute->buffers.at(table.buffer)->name(), formatOf(table.texel));
    }
    if (run->parameterBytes > 0) {
      compute->parameters->fill(run->parameters, run->parameterBytes, GL_STREAM_DRAW);
      glBindBufferBase(GL_UNIFORM_BUFFER, 0, compute->parameters->name());
    }
    for (std::uint64_t first = 0; first < run->invocations; first += compute->groups * kGroup) {
      const std::uint64_t end = std::min(first + compute->groups * kGroup, run->invocations);
      glUniform1ui(kFirst, static_cast<GLuint>(first));
      glUniform1ui(kEnd, static_cast<GLuint>(end));
      glDispatchCompute(static_cast<GLuint>((end - first + kGroup - 1) / kGroup), 1, 1);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    glUseProgram(0);
    checkGl("a program cannot be run");
  });
}

ScanmillVtkStatus finish(ScanmillCompute* compute, ScanmillVtkText* error) {
  return withContext(*compute, *error, [] {
    glFinish();
    checkGl("the device failed");
  });
}

}  // namespace

constexpr ScanmillComputeFunctions kComputeFunctions{open,   close, makeProgram, makeBuffer, dropProgram, dropBuffer,
                                                     resize, write, read,        run,        finish};

}  // namespace scanmill
