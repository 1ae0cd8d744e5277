#include "passes/vtk_module/pixel_reader.h"

#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLState.h>

#include <algorithm>

namespace scanmill {

namespace {

constexpr std::uint32_t kGroup = 64;
constexpr std::size_t kMostAtOnce = std::size_t{kGroup} * 65535;  // most addresses per dispatch; OpenGL guarantees
                                                                  // 65535 groups

// Reads pixels from several images. The shader loops over all images, because the index of a sampler must be the same
// for all invocations.
constexpr const char* kGather = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Addresses { uint addresses[]; };
layout(std430, binding = 1) writeonly buffer Numbers { uint numbers[]; };
uniform usampler2D images[8];
uniform uint firsts[9];
uniform uint widths[8];
uniform uint imageCount;
uniform uint count;
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  uint address = addresses[i];
  uint number = 0u;
  for (uint k = 0u; k < imageCount; ++k) {
    if (address >= firsts[k] && address < firsts[k + 1u]) {
      uint pixel = address - firsts[k];
      number = texelFetch(images[k], ivec2(pixel % widths[k], pixel / widths[k]), 0).r;
    }
  }
  numbers[i] = number;
}
)";

}  // namespace

GlPixelReader::GlPixelReader() : program_("gather", {{GL_COMPUTE_SHADER, kGather}}) {
  glGenFramebuffers(1, &frame_);
}

GlPixelReader::~GlPixelReader() {
  glDeleteFramebuffers(1, &frame_);
}

void GlPixelReader::gather(const std::array<vtkTextureObject*, kVtkImages>& images, const VtkPixels& pixels,
                           std::span<const std::uint32_t> addresses, std::uint32_t* numbers) {
  std::array<GLint, kVtkImages> units{};
  GLuint count = 0;
  for (std::size_t k = 0; k < kVtkImages; ++k) {
    if (images[k]->GetHandle() == 0 || pixels.firsts[k] == pixels.firsts[k + 1]) continue;
    images[k]->Activate();
    units[k] = images[k]->GetTextureUnit();
    count = static_cast<GLuint>(k + 1);
  }
  program_.use();
  glUniform1iv(program_.uniform("images"), kVtkImages, units.data());
  glUniform1uiv(program_.uniform("firsts"), kVtkImages + 1, pixels.firsts);
  glUniform1uiv(program_.uniform("widths"), kVtkImages, pixels.widths);
  glUniform1ui(program_.uniform("imageCount"), count);
  while (!addresses.empty()) {
    const std::size_t now = std::min(addresses.size(), kMostAtOnce);
    const std::size_t bytes = now * sizeof(std::uint32_t);
    addresses_.fill(addresses.data(), bytes, GL_STREAM_DRAW);
    numbers_.reserve(bytes, GL_STREAM_READ);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, addresses_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, numbers_.name());
    glUniform1ui(program_.uniform("count"), static_cast<GLuint>(now));
    glDispatchCompute(static_cast<GLuint>((now + kGroup - 1) / kGroup), 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBuffer(GL_COPY_READ_BUFFER, numbers_.name());
    glGetBufferSubData(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(bytes), numbers);
    addresses = addresses.subspan(now);
    numbers += now;
  }
  glUseProgram(0);
  for (vtkTextureObject* image : images) {
    if (image->GetHandle() != 0) image->Deactivate();
  }
  checkGl("pixels cannot be read back");
}

void GlPixelReader::read(vtkTextureObject* image, std::uint32_t firstRow, std::uint32_t rows, std::uint32_t* numbers) {
  vtkOpenGLState* state = image->GetContext()->GetState();
  state->PushFramebufferBindings();
  state->vtkglBindFramebuffer(GL_READ_FRAMEBUFFER, frame_);
  glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, image->GetHandle(), 0);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  state->vtkglPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, static_cast<GLint>(firstRow), static_cast<GLsizei>(image->GetWidth()), static_cast<GLsizei>(rows),
               GL_RED_INTEGER, GL_UNSIGNED_INT, numbers);
  glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
  state->PopFramebufferBindings();
  checkGl("an image cannot be read back");
}

}  // namespace scanmill
