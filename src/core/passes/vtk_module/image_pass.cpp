#include "passes/vtk_module/image_pass.h"

#include <fmt/format.h>
#include <vtkOpenGLState.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <vector>

namespace scanmill {

namespace {

// Locations of the vertex attributes; the shaders have the same numbers.
enum VertexAttribute : GLuint { kPosition = 0, kRows = 1, kFirstNumber = 4, kUv = 5, kCutout = 6 };
// Bindings of the shaders' storage buffers.
enum StorageBinding : GLuint { kCutouts = 0, kWords = 1 };

// The depth buffer contains the near clipping distance divided by w, which decreases with distance. The relative
// precision of float32 is the same for small and large numbers, and so is the relative precision of the depth near and
// far (Reed, "Depth precision visualized", 2015). There is no far clipping plane. If the depths of clip space are from
// -1 to 1, OpenGL's mapping to 0 to 1 loses that precision. Solid triangles have no textureUv and no cutoutIndex.
constexpr const char* kVertex = R"(#version 430 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 rows[3];
layout(location = 4) in uint firstNumber;
layout(location = 5) in vec2 textureUv;
layout(location = 6) in uint cutoutIndex;
uniform vec2 depthFromW;
flat out uint number;
flat out uint cutout;
out vec2 uv;
invariant gl_Position;
void main() {
  vec4 point = vec4(position, 1.0);
  float w = dot(rows[2], point);
  gl_Position = vec4(dot(rows[0], point), dot(rows[1], point), depthFromW.x + depthFromW.y * w, w);
  number = firstNumber + uint(gl_VertexID) / 3u;
  cutout = cutoutIndex;
  uv = textureUv;
}
)";

constexpr const char* kSolidFragment = R"(#version 430 core
flat in uint number;
layout(location = 0) out uint seen;
void main() {
  seen = number;
}
)";

// Selects the same texel as Texture::texel: the nearest one, with repetition.
constexpr const char* kCutFragment = R"(#version 430 core
flat in uint number;
flat in uint cutout;
in vec2 uv;
layout(std430, binding = 0) readonly buffer Cutouts { uvec4 cutouts[]; };
layout(std430, binding = 1) readonly buffer Words { uint words[]; };
layout(location = 0) out uint seen;
uint texel(float coordinate, uint size) {
  float part = coordinate - floor(coordinate);
  return part > 0.0 ? min(uint(part * float(size)), size - 1u) : 0u;
}
void main() {
  uvec4 image = cutouts[cutout];
  uint bit = texel(uv.y, image.z) * image.y + texel(uv.x, image.y);
  if ((words[image.x + (bit >> 5)] >> (bit & 31u) & 1u) != 0u) discard;
  seen = number;
}
)";

// The layout of commands that glMultiDrawArraysIndirect reads.
struct Command {
  GLuint vertices;
  GLuint instances;
  GLuint firstVertex;
  GLuint firstInstance;
};

template <class T>
void upload(GlBuffer& buffer, const std::vector<T>& data) {
  static constexpr T kPlaceholder{};  // a buffer without storage cannot be bound
  if (data.empty()) {
    buffer.fill(&kPlaceholder, sizeof kPlaceholder, GL_STATIC_DRAW);
  } else {
    buffer.fill(data.data(), data.size() * sizeof(T), GL_STATIC_DRAW);
  }
}

// Adds the attributes of solid triangles: a position per vertex, and a placement per instance.
void addPositions(GlVertexArray& array, const GlBuffer& positions, const GlBuffer& placements) {
  array.add({.location = kPosition, .buffer = &positions, .components = 3, .stride = 3 * sizeof(float)});
  for (GLuint row = 0; row < 3; ++row) {
    array.add({.location = kRows + row,
               .buffer = &placements,
               .components = 4,
               .stride = sizeof(VtkPlacement),
               .offset = row * 4 * sizeof(float),
               .divisor = 1});
  }
  array.add({.location = kFirstNumber,
             .buffer = &placements,
             .components = 1,
             .integer = true,
             .stride = sizeof(VtkPlacement),
             .offset = offsetof(VtkPlacement, firstNumber),
             .divisor = 1});
}

}  // namespace

void ImagePass::compilePrograms(vtkOpenGLRenderWindow* window) {
  using Shaders = std::initializer_list<GlShaderText>;
  zeroToOne_ = GLEW_VERSION_4_5 || GLEW_ARB_clip_control;
  solid_ =
      std::make_unique<GlProgram>("solid", Shaders{{GL_VERTEX_SHADER, kVertex}, {GL_FRAGMENT_SHADER, kSolidFragment}});
  cut_ =
      std::make_unique<GlProgram>("cut-out", Shaders{{GL_VERTEX_SHADER, kVertex}, {GL_FRAGMENT_SHADER, kCutFragment}});
  frame_->SetContext(window);
}

// Gives the textures the size of the image. The texture of numbers is reused for the next image of the same size; the
// depth buffer, which all images share, only grows.
void ImagePass::prepareTextures(vtkOpenGLRenderWindow* window, const VtkImage& image, vtkTextureObject* numbers) {
  if (numbers->GetWidth() != image.width || numbers->GetHeight() != image.height) {
    numbers->SetContext(window);
    numbers->SetInternalFormat(GL_R32UI);
    numbers->SetFormat(GL_RED_INTEGER);
    numbers->SetDataType(GL_UNSIGNED_INT);
    numbers->SetMinificationFilter(vtkTextureObject::Nearest);
    numbers->SetMagnificationFilter(vtkTextureObject::Nearest);
    if (!numbers->Allocate2D(image.width, image.height, 1, VTK_UNSIGNED_INT)) throw std::bad_alloc();
  }
  const bool isFirst = depth_->GetHandle() == 0;
  if (isFirst || depth_->GetWidth() < image.width || depth_->GetHeight() < image.height) {
    const unsigned width = std::max(isFirst ? 0 : depth_->GetWidth(), image.width);
    const unsigned height = std::max(isFirst ? 0 : depth_->GetHeight(), image.height);
    depth_->SetContext(window);
    if (!depth_->AllocateDepth(width, height, vtkTextureObject::Float32)) throw std::bad_alloc();
  }
  checkGl("an image cannot be made");
}

void ImagePass::draw(vtkOpenGLRenderWindow* window, TriangleStore& triangles, const VtkImage& image,
                     std::uint32_t slot) {
  if (!solid_) compilePrograms(window);
  prepareTextures(window, image, slots_[slot]);
  vtkOpenGLState* state = window->GetState();
  state->Push();
  state->PushFramebufferBindings();
  frame_->Bind();
  frame_->AddColorAttachment(0, slots_[slot]);
  frame_->AddDepthAttachment(depth_);
  frame_->ActivateDrawBuffer(0);

  state->vtkglViewport(0, 0, static_cast<int>(image.width), static_cast<int>(image.height));
  for (const GLenum capability : {GL_SCISSOR_TEST, GL_BLEND, GL_CULL_FACE, GL_MULTISAMPLE}) {
    state->vtkglDisable(capability);
  }
  state->vtkglEnable(GL_DEPTH_TEST);
  state->vtkglDepthMask(GL_TRUE);
  state->vtkglDepthFunc(GL_GREATER);
  state->vtkglColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  if (zeroToOne_) glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);

  const GLuint noTriangle[4] = {0, 0, 0, 0};
  const GLfloat infiniteDepth = 0;  // nearest / w: see kVertex
  glClearBufferuiv(GL_COLOR, 0, noTriangle);
  glClearBufferfv(GL_DEPTH, 0, &infiniteDepth);
  triangles.uploadPlacements(image.placements);
  const auto drawBatch = [&](const GlProgram& program, bool cut, std::span<const VtkDraw> draws) {
    program.use();
    glUniform2f(program.uniform("depthFromW"), zeroToOne_ ? image.nearest : 2 * image.nearest,
                zeroToOne_ ? 0.0f : -1.0f);
    triangles.draw(cut, draws);
  };
  drawBatch(*solid_, false, image.solid);
  drawBatch(*cut_, true, image.cut);
  glUseProgram(0);

  if (zeroToOne_) glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  frame_->RemoveColorAttachment(0);
  frame_->RemoveDepthAttachment();
  state->PopFramebufferBindings();
  state->Pop();
  checkGl("an image cannot be drawn");
}

void ImagePass::releaseGraphicsResources(vtkOpenGLRenderWindow* window) {
  solid_.reset();
  cut_.reset();
  frame_->ReleaseGraphicsResources(window);
  depth_->ReleaseGraphicsResources(window);
  for (const auto& slot : slots_) slot->ReleaseGraphicsResources(window);
}

TriangleStore::TriangleStore(const ViewGeometry& scene) {
  GLint64 largestBuffer = 0;  // bytes
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largestBuffer);
  if (scene.cutoutWords.size() * sizeof(std::uint32_t) > static_cast<std::uint64_t>(largestBuffer)) {
    throw std::runtime_error(fmt::format(
        "the textures with alpha have {} texels, more than the {} that OpenGL takes here: make them smaller",
        scene.cutoutWords.size() * 32, largestBuffer * 8));
  }
  upload(solidPositions_, scene.solid.positions);
  upload(cutPositions_, scene.cut.positions);
  upload(cutUvs_, scene.cut.uvs);
  upload(cutCutouts_, scene.cut.cutouts);
  upload(cutouts_, scene.cutouts);
  upload(cutoutWords_, scene.cutoutWords);
  addPositions(solid_, solidPositions_, placements_);
  addPositions(cut_, cutPositions_, placements_);
  cut_.add({.location = kUv, .buffer = &cutUvs_, .components = 2, .stride = 2 * sizeof(float)});
  cut_.add(
      {.location = kCutout, .buffer = &cutCutouts_, .components = 1, .integer = true, .stride = sizeof(std::uint32_t)});
  checkGl("the scene's triangles cannot be uploaded");
}

void TriangleStore::uploadPlacements(std::span<const VtkPlacement> placements) {
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
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kWords, cutoutWords_.name());
  }
  (cut ? cut_ : solid_).bind();
  glMultiDrawArraysIndirect(GL_TRIANGLES, nullptr, static_cast<GLsizei>(commands.size()), 0);
  glBindVertexArray(0);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

}  // namespace scanmill
