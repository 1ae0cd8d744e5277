#pragma once

// OpenGL's buffers, vertex arrays and programs as C++ objects. Each object belongs to the context in which it was
// created, which must be current when the object is used.

#include <vtk_glew.h>

#include <cstddef>
#include <initializer_list>
#include <string_view>

namespace scanmill {

// Throws if OpenGL has reported an error since the last call: std::bad_alloc if it is out of memory, otherwise
// std::runtime_error with the message "<doing>: OpenGL error ...". Also throws if the graphics card was reset.
void checkGl(std::string_view doing);

class GlBuffer {
 public:
  GlBuffer() { glGenBuffers(1, &name_); }
  ~GlBuffer() { glDeleteBuffers(1, &name_); }
  GlBuffer& operator=(GlBuffer&&) = delete;  // neither copied nor moved

  GLuint name() const { return name_; }
  // Replaces the buffer's contents by `bytes` bytes from `data`; if `data` is null, the contents are undefined.
  void fill(const void* data, std::size_t bytes, GLenum usage);
  // Makes the buffer at least this large. If it grows, its contents are lost.
  void reserve(std::size_t bytes, GLenum usage);

 private:
  GLuint name_ = 0;
  std::size_t bytes_ = 0;
};

// A vertex attribute that is read from a buffer: `components` floats, or uint32 if `integer` is true. The buffer has
// one element per vertex if `divisor` is 0, and one per instance if it is 1. `stride` and `offset` are in bytes.
struct GlAttribute {
  GLuint location;
  const GlBuffer* buffer;
  GLint components;
  bool integer = false;
  std::size_t stride;
  std::size_t offset = 0;
  GLuint divisor = 0;
};

class GlVertexArray {
 public:
  GlVertexArray() { glGenVertexArrays(1, &name_); }
  ~GlVertexArray() { glDeleteVertexArrays(1, &name_); }
  GlVertexArray& operator=(GlVertexArray&&) = delete;  // neither copied nor moved

  void add(const GlAttribute& attribute);
  void bind() const { glBindVertexArray(name_); }

 private:
  GLuint name_ = 0;
};

struct GlShaderText {
  GLenum kind;
  const char* text;
};

class GlProgram {
 public:
  // Compiles and links shaders. `name`: for messages. Throws std::runtime_error with the compiler's message.
  GlProgram(std::string_view name, std::initializer_list<GlShaderText> shaders);
  ~GlProgram() { glDeleteProgram(name_); }
  GlProgram& operator=(GlProgram&&) = delete;  // neither copied nor moved

  void use() const { glUseProgram(name_); }
  GLint uniform(const char* name) const { return glGetUniformLocation(name_, name); }

 private:
  GLuint name_ = 0;
};

}  // namespace scanmill
