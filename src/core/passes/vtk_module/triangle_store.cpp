#include "passes/vtk_module/triangle_store.h"

#include <fmt/format.h>

#include <stdexcept>
#include <vector>

namespace scanmill {

namespace {

// The layout of commands that glMultiDrawArraysIndirect reads.
struct Command {
  GLuint count;
  GLuint instances;
  GLuint first;
  GLuint baseInstance;
};

template <class T>
void upload(GlBuffer& buffer, std::span<const T> data) {
  static constexpr std::uint32_t kNothing = 0;  // a buffer without storage cannot be bound
  if (data.empty()) {
    buffer.fill(&kNothing, sizeof kNothing, GL_STATIC_DRAW);
  } else {
    buffer.fill(data.data(), data.size_bytes(), GL_STATIC_DRAW);
  }
}

void addPositions(GlVertexArray& array, const GlBuffer& positions, const GlBuffer& placements) {
  constexpr std::size_t kStride = sizeof(VtkPlacement);
  array.add({kPosition, &positions, 3, false, 3 * sizeof(float), 0, 0});
  for (GLuint row = 0; row < 3; ++row) {
    array.add({kRows + row, &placements, 4, false, kStride, row * 4 * sizeof(float), 1});
  }
  array.add({kFirstNumber, &placements, 1, true, kStride, offsetof(VtkPlacement, firstNumber), 1});
}

}  // namespace

TriangleStore::TriangleStore(const VtkScene& scene) {
  GLint64 largest = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  if (scene.words.size_bytes() > static_cast<std::uint64_t>(largest)) {
    throw std::runtime_error(fmt::format(
        "the textures with alpha have {} texels, more than the {} that OpenGL takes here: make them smaller",
        scene.words.size() * 32, largest * 8));
  }
  upload(solidPositions_, scene.solid.positions);
  upload(cutPositions_, scene.cut.positions);
  upload(cutUvs_, scene.cut.uvs);
  upload(cutCutouts_, scene.cut.cutouts);
  upload(cutouts_, scene.cutouts);
  upload(words_, scene.words);
  addPositions(solid_, solidPositions_, placements_);
  addPositions(cut_, cutPositions_, placements_);
  cut_.add({kUv, &cutUvs_, 2, false, 2 * sizeof(float), 0, 0});
  cut_.add({kCutout, &cutCutouts_, 1, true, sizeof(std::uint32_t), 0, 0});
  checkGl("the scene's triangles cannot be uploaded");
}

void TriangleStore::place(std::span<const VtkPlacement> placements) {
  placements_.fill(placements.data(), placements.size_bytes(), GL_STREAM_DRAW);
}

void TriangleStore::draw(bool cut, std::span<const VtkDraw> draws) {
  if (draws.empty()) return;
  std::vector<Command> commands(draws.size());
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const VtkDraw& d = draws[i];
    commands[i] = {d.triangles * 3, d.placements, d.firstTriangle * 3, d.firstPlacement};
  }
  commands_.fill(commands.data(), commands.size() * sizeof(Command), GL_STREAM_DRAW);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
  if (cut) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCutouts, cutouts_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kWords, words_.name());
  }
  (cut ? cut_ : solid_).bind();
  glMultiDrawArraysIndirect(GL_TRIANGLES, nullptr, static_cast<GLsizei>(commands.size()), 0);
  glBindVertexArray(0);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

}  // namespace scanmill
