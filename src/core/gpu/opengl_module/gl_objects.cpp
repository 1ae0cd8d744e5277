#include "gpu/opengl_module/gl_objects.h"

#include <fmt/format.h>

#include <new>
#include <stdexcept>

namespace scanmill {

namespace {

// Returns the log of a shader or program. `length`, `text`: OpenGL's functions that give the log's length and text.
std::string logOf(GLuint object, void (*length)(GLuint, GLenum, GLint*),
                  void (*text)(GLuint, GLsizei, GLsizei*, GLchar*)) {
  GLint size = 0;
  length(object, GL_INFO_LOG_LENGTH, &size);
  std::string log(static_cast<std::size_t>(size > 0 ? size : 0), '\0');
  GLsizei written = 0;
  if (size > 0) text(object, size, &written, log.data());
  log.resize(static_cast<std::size_t>(written));
  return log;
}

}  // namespace

void checkGl(std::string_view doing) {
  const GLenum error = glGetError();
  const GLenum reset = GLEW_VERSION_4_5      ? glGetGraphicsResetStatus()
                       : GLEW_ARB_robustness ? glGetGraphicsResetStatusARB()
                                             : GLenum{GL_NO_ERROR};
  if (reset != GL_NO_ERROR) throw std::runtime_error("the graphics card was reset, and all that it held is lost");
  if (error == GL_NO_ERROR) return;
  constexpr int kMostErrors = 64;  // a lost context may report errors for ever
  for (int k = 0; k < kMostErrors && glGetError() != GL_NO_ERROR; ++k) continue;
  if (error == GL_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error(fmt::format("{}: OpenGL error {:#x}", doing, error));
}

void GlBuffer::fill(const void* data, std::size_t bytes, GLenum usage) {
  bytes_ = bytes;
  glBindBuffer(GL_COPY_WRITE_BUFFER, name_);
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), data, usage);
}

void GlBuffer::reserve(std::size_t bytes, GLenum usage) {
  if (bytes > bytes_) fill(nullptr, bytes, usage);
}

void GlVertexArray::add(const GlAttribute& attribute) {
  bind();
  glBindBuffer(GL_ARRAY_BUFFER, attribute.buffer->name());
  // NOLINTNEXTLINE(performance-no-int-to-ptr): an offset that OpenGL takes as a pointer
  const auto* offset = reinterpret_cast<const void*>(attribute.offset);
  const auto stride = static_cast<GLsizei>(attribute.stride);
  if (attribute.integer) {
    glVertexAttribIPointer(attribute.location, attribute.components, GL_UNSIGNED_INT, stride, offset);
  } else {
    glVertexAttribPointer(attribute.location, attribute.components, GL_FLOAT, GL_FALSE, stride, offset);
  }
  glVertexAttribDivisor(attribute.location, attribute.divisor);
  glEnableVertexAttribArray(attribute.location);
  glBindVertexArray(0);
}

GlProgram::GlProgram(std::string_view name, std::initializer_list<GlShaderText> shaders) : name_(glCreateProgram()) {
  for (const GlShaderText& shader : shaders) {
    const GLuint compiled = glCreateShader(shader.kind);
    glShaderSource(compiled, 1, &shader.text, nullptr);
    glCompileShader(compiled);
    GLint status = GL_FALSE;
    glGetShaderiv(compiled, GL_COMPILE_STATUS, &status);
    if (status != GL_TRUE) {
      const std::string log = logOf(compiled, glGetShaderiv, glGetShaderInfoLog);
      glDeleteShader(compiled);
      glDeleteProgram(name_);
      throw std::runtime_error(fmt::format("the driver does not compile the {} shader: {}", name, log));
    }
    glAttachShader(name_, compiled);
    glDeleteShader(compiled);  // takes effect when the program is deleted
  }
  glLinkProgram(name_);
  GLint status = GL_FALSE;
  glGetProgramiv(name_, GL_LINK_STATUS, &status);
  if (status != GL_TRUE) {
    const std::string log = logOf(name_, glGetProgramiv, glGetProgramInfoLog);
    glDeleteProgram(name_);
    throw std::runtime_error(fmt::format("the driver does not link the {} shader: {}", name, log));
  }
}

}  // namespace scanmill
