#include "passes/vtk_module/image_pass.h"

#include <fmt/format.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLState.h>
#include <vtkRenderState.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <vector>

namespace scanmill {

namespace {

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
  GLuint count;
  GLuint instances;
  GLuint first;
  GLuint baseInstance;
};

template <class T>
void upload(GlBuffer& buffer, const std::vector<T>& data) {
  static constexpr std::uint32_t kNothing = 0;  // a buffer without storage cannot be bound
  if (data.empty()) {
    buffer.fill(&kNothing, sizeof kNothing, GL_STATIC_DRAW);
  } else {
    buffer.fill(data.data(), data.size() * sizeof(T), GL_STATIC_DRAW);
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

vtkStandardNewMacro(ImagePass);

void ImagePass::next(TriangleStore* triangles, const VtkImage* image, std::uint32_t slot) {
  triangles_ = triangles;
  image_ = image;
  slot_ = slot;
}

void ImagePass::Render(const vtkRenderState* state) {
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(state->GetRenderer()->GetRenderWindow());
  prepare(window);
  draw(window);
}

// Creates programs and textures. Textures are reused for the next image of the same size.
void ImagePass::prepare(vtkOpenGLRenderWindow* window) {
  if (!solid_) {
    zeroToOne_ = GLEW_VERSION_4_5 || GLEW_ARB_clip_control;
    solid_ = std::make_unique<GlProgram>(
        "solid",
        std::initializer_list<GlShaderText>{{GL_VERTEX_SHADER, kVertex}, {GL_FRAGMENT_SHADER, kSolidFragment}});
    cut_ = std::make_unique<GlProgram>("cut-out", std::initializer_list<GlShaderText>{
                                                      {GL_VERTEX_SHADER, kVertex}, {GL_FRAGMENT_SHADER, kCutFragment}});
    frame_->SetContext(window);
  }
  vtkTextureObject* numbers = slots_[slot_];
  if (numbers->GetWidth() != image_->width || numbers->GetHeight() != image_->height) {
    numbers->SetContext(window);
    numbers->SetInternalFormat(GL_R32UI);
    numbers->SetFormat(GL_RED_INTEGER);
    numbers->SetDataType(GL_UNSIGNED_INT);
    numbers->SetMinificationFilter(vtkTextureObject::Nearest);
    numbers->SetMagnificationFilter(vtkTextureObject::Nearest);
    if (!numbers->Allocate2D(image_->width, image_->height, 1, VTK_UNSIGNED_INT)) throw std::bad_alloc();
  }
  const bool first = depth_->GetHandle() == 0;
  if (first || depth_->GetWidth() < image_->width || depth_->GetHeight() < image_->height) {
    const unsigned width = std::max(first ? 0 : depth_->GetWidth(), image_->width);
    const unsigned height = std::max(first ? 0 : depth_->GetHeight(), image_->height);
    depth_->SetContext(window);
    if (!depth_->AllocateDepth(width, height, vtkTextureObject::Float32)) throw std::bad_alloc();
  }
  checkGl("an image cannot be made");
}

void ImagePass::draw(vtkOpenGLRenderWindow* window) {
  vtkOpenGLState* state = window->GetState();
  state->Push();
  state->PushFramebufferBindings();
  frame_->Bind();
  frame_->AddColorAttachment(0, slots_[slot_]);
  frame_->AddDepthAttachment(depth_);
  frame_->ActivateDrawBuffer(0);

  state->vtkglViewport(0, 0, static_cast<int>(image_->width), static_cast<int>(image_->height));
  state->vtkglDisable(GL_SCISSOR_TEST);
  state->vtkglDisable(GL_BLEND);
  state->vtkglDisable(GL_CULL_FACE);
  state->vtkglDisable(GL_MULTISAMPLE);
  state->vtkglEnable(GL_DEPTH_TEST);
  state->vtkglDepthMask(GL_TRUE);
  state->vtkglDepthFunc(GL_GREATER);
  state->vtkglColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  if (zeroToOne_) glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);

  const GLuint nothing[4] = {0, 0, 0, 0};
  const GLfloat infinity = 0;
  glClearBufferuiv(GL_COLOR, 0, nothing);
  glClearBufferfv(GL_DEPTH, 0, &infinity);
  triangles_->place(image_->placements);
  const auto run = [&](const GlProgram& program, bool cut, std::span<const VtkDraw> draws) {
    program.use();
    const float nearest = image_->nearest;
    glUniform2f(program.uniform("depthFromW"), zeroToOne_ ? nearest : 2 * nearest, zeroToOne_ ? 0.0f : -1.0f);
    triangles_->draw(cut, draws);
  };
  run(*solid_, false, image_->solid);
  run(*cut_, true, image_->cut);
  glUseProgram(0);

  if (zeroToOne_) glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  frame_->RemoveColorAttachment(0);
  frame_->RemoveDepthAttachment();
  state->PopFramebufferBindings();
  state->Pop();
  checkGl("an image cannot be drawn");
}

void ImagePass::ReleaseGraphicsResources(vtkWindow* window) {
  solid_.reset();
  cut_.reset();
  frame_->ReleaseGraphicsResources(window);
  depth_->ReleaseGraphicsResources(window);
  for (const auto& slot : slots_) slot->ReleaseGraphicsResources(window);
  vtkRenderPass::ReleaseGraphicsResources(window);
}

TriangleStore::TriangleStore(const ViewGeometry& scene) {
  GLint64 largest = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  if (scene.cutoutWords.size() * sizeof(std::uint32_t) > static_cast<std::uint64_t>(largest)) {
    throw std::runtime_error(fmt::format(
        "the textures with alpha have {} texels, more than the {} that OpenGL takes here: make them smaller",
        scene.cutoutWords.size() * 32, largest * 8));
  }
  upload(solidPositions_, scene.solid.positions);
  upload(cutPositions_, scene.cut.positions);
  upload(cutUvs_, scene.cut.uvs);
  upload(cutCutouts_, scene.cut.cutouts);
  upload(cutouts_, scene.cutouts);
  upload(words_, scene.cutoutWords);
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
