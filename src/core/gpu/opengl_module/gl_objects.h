#pragma once

// OpenGL's buffers, vertex arrays and programs as C++ objects. They belong to the context that is current.

#include <vtk_glew.h>

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>

namespace scanmill {

// Throws std::bad_alloc if OpenGL ran out of memory, and std::runtime_error for any other error: "<doing>: OpenGL error
// ...".
void checkGl(std::string_view doing);

class GlBuffer {
 public:
  GlBuffer() { glGenBuffers(1, &name_); }
  ~GlBuffer() { glDeleteBuffers(1, &name_); }
  GlBuffer(const GlBuffer&) = delete;
  GlBuffer& operator=(const GlBuffer&) = delete;

  GLuint name() const { return name_; }
  // Replaces the contents, which are undefined if `data` is null.
  void fill(const void* data, std::size_t bytes, GLenum usage);
  // Makes the buffer at least this large. Its contents are lost if it grows.
  void reserve(std::size_t bytes, GLenum usage);

 private:
  GLuint name_ = 0;
  std::size_t bytes_ = 0;
};

// A vertex attribute, read from a buffer's elements: `components` floats, or as many uint32 if `integer` is set. There
// is one element per vertex if `divisor` is 0, and one per instance if it is 1.
struct GlAttribute {
  GLuint location;
  const GlBuffer* buffer;
  GLint components;
  bool integer;
  std::size_t stride;
  std::size_t offset;
  GLuint divisor;
};

class GlVertexArray {
 public:
  GlVertexArray() { glGenVertexArrays(1, &name_); }
  ~GlVertexArray() { glDeleteVertexArrays(1, &name_); }
  GlVertexArray(const GlVertexArray&) = delete;
  GlVertexArray& operator=(const GlVertexArray&) = delete;

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
  // Throws std::runtime_error with the compiler's message.
  GlProgram(std::string_view name, std::initializer_list<GlShaderText> shaders);
  ~GlProgram() { glDeleteProgram(name_); }
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const { glUseProgram(name_); }
  const std::string& label() const { return label_; }  // the constructor's `name`
  GLint uniform(const char* name) const { return glGetUniformLocation(name_, name); }

 private:
  GLuint name_ = 0;
  std::string label_;
};

}  // namespace scanmill
