#include "viewer/vtk_module/canvas_scene.h"

#include <fmt/format.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkShaderProgram.h>
#include <vtk_glew.h>

#include <new>
#include <utility>

namespace scanmill {

namespace {

void checkSize(int width, int height) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (width < 1 || height < 1 || width > limit || height > limit) {
    throw std::invalid_argument(
        fmt::format("a canvas of {} x {} pixels cannot be drawn: take 1 to {} a side", width, height, limit));
  }
}

constexpr const char* kVertex = R"(//VTK::System::Dec
in vec2 pixel;
in vec2 textureCoordinates;
in vec4 color;
uniform vec2 canvasSize;
out vec2 imagePosition;
out vec4 tint;

void main() {
  imagePosition = textureCoordinates;
  tint = color;
  gl_Position = vec4(2.0 * pixel.x / canvasSize.x - 1.0, 1.0 - 2.0 * pixel.y / canvasSize.y, 0.0, 1.0);
}
)";

constexpr const char* kFragment = R"(//VTK::System::Dec
//VTK::Output::Dec
in vec2 imagePosition;
in vec4 tint;
uniform sampler2D image;

void main() {
  gl_FragData[0] = tint * texture(image, imagePosition);
}
)";

const void* offsetPointer(std::size_t bytes) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): an offset that OpenGL takes as a pointer
  return reinterpret_cast<const void*>(bytes);
}

}  // namespace

CanvasScene::CanvasScene(int width, int height) : width_(width), height_(height) {
  checkSize(width, height);
  window_->start(width, height);
  window_->SetFrameBlitModeToNoBlit();
  uncovered_->SetBackground(0, 0, 0);
  uncovered_->InteractiveOff();
  for (const auto& renderer : renderers_) renderer->useEdges(&edges_);
  placeViews();
}

CanvasScene::~CanvasScene() {
  for (auto& [number, item] : items_) remove(*item);
  edges_.release(window_);
  overlay_.release(window_);
  window_->Finalize();
}

void CanvasScene::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  checkSize(width, height);
  width_ = width;
  height_ = height;
  hasPicture_ = false;
  window_->SetSize(width, height);
  placeViews();
}

void CanvasScene::setViews(std::span<const CanvasView> views) {
  views_.assign(views.begin(), views.end());
  placeViews();
}

void CanvasScene::placeViews() {
  viewsDrawn_ = false;
  // The black background is added first, so that the views are drawn on top of it.
  window_->AddRenderer(uncovered_);
  for (std::size_t k = 0; k < renderers_.size(); ++k) {
    const bool isOnCanvas = k < views_.size() && views_[k].rect.left < width_ && views_[k].rect.top < height_;
    if (isOnCanvas) renderers_[k]->setView(views_[k], width_, height_);
    isOnCanvas ? window_->AddRenderer(renderers_[k]) : window_->RemoveRenderer(renderers_[k]);
  }
}

Item& CanvasScene::item(ItemId number) {
  const auto found = items_.find(number);
  if (found == items_.end()) throw std::invalid_argument(fmt::format("the canvas has no item {}", number));
  return *found->second;
}

void CanvasScene::set(ItemId number, ItemKind kind, std::span<const Vec3f> corners, std::span<const Rgb> colors) {
  if (corners.size() != colors.size() * static_cast<std::size_t>(kind)) {
    throw std::invalid_argument(fmt::format("{} colors for {} corners", colors.size(), corners.size()));
  }
  viewsDrawn_ = false;
  std::unique_ptr<Item>& item = items_[number];
  if (item == nullptr || item->kind() != kind) {
    const ItemLook look = item != nullptr ? item->look() : ItemLook{};
    if (item != nullptr) remove(*item);
    item = std::make_unique<Item>(kind);
    item->setLook(look);
    place(*item);
  }
  item->set(corners, colors);
}

void CanvasScene::setColors(ItemId number, std::span<const Rgb> colors) {
  viewsDrawn_ = false;
  Item& changed = item(number);
  if (colors.size() != changed.count()) {
    throw std::invalid_argument(fmt::format("item {} has {} elements, not {}", number, changed.count(), colors.size()));
  }
  changed.setColors(colors);
}

void CanvasScene::show(ItemId number, std::optional<std::vector<std::uint32_t>> indices) {
  viewsDrawn_ = false;
  item(number).show(std::move(indices));
}

void CanvasScene::setLook(ItemId number, const ItemLook& look) {
  viewsDrawn_ = false;
  Item& changed = item(number);
  changed.setLook(look);
  place(changed);
}

void CanvasScene::drop(ItemId number) {
  const auto found = items_.find(number);
  if (found == items_.end()) return;
  viewsDrawn_ = false;
  remove(*found->second);
  items_.erase(found);
}

// Adds the item to the views that its look selects, and removes it from the other views. VTK ignores an actor that is
// added again, and the removal of an actor that it does not have.
void CanvasScene::place(Item& item) {
  for (std::uint32_t k = 0; k < kCanvasViews; ++k) {
    const bool isInView = (item.look().views >> k & 1u) != 0;
    for (vtkActor* actor : item.actors()) isInView ? renderers_[k]->AddActor(actor) : renderers_[k]->RemoveActor(actor);
  }
}

void CanvasScene::remove(Item& item) {
  for (const auto& renderer : renderers_) {
    for (vtkActor* actor : item.actors()) renderer->RemoveActor(actor);
  }
}

void CanvasScene::setImage(ImageId image, int width, int height, std::span<const Rgba> pixels) {
  checkSize(width, height);
  overlay_.setImage(window_, image, width, height, pixels);
}

// Draws the views, if they have changed, to VTK's render framebuffer, which keeps them. Then copies them to the display
// framebuffer and draws the overlay on top. `maxPoints`: see Canvas::render().
void CanvasScene::draw(std::uint64_t maxPoints) {
  vtkOpenGLState* state = window_->GetState();
  if (!viewsDrawn_ || drawnMaxPoints_ != maxPoints) {
    for (auto& [number, item] : items_) item->choose(maxPoints);
    window_->Render();
    viewsDrawn_ = true;
    drawnMaxPoints_ = maxPoints;
  }
  state->Push();
  state->PushFramebufferBindings();
  window_->GetRenderFramebuffer()->Bind(GL_READ_FRAMEBUFFER);
  window_->GetRenderFramebuffer()->ActivateReadBuffer(0);
  window_->GetDisplayFramebuffer()->Bind(GL_DRAW_FRAMEBUFFER);
  window_->GetDisplayFramebuffer()->ActivateDrawBuffer(0);
  state->vtkglDisable(GL_SCISSOR_TEST);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  overlay_.draw(window_, width_, height_);
  state->PopFramebufferBindings();
  state->Pop();
  hasPicture_ = true;
}

void CanvasScene::read(std::span<Rgb> pixels) {
  if (!hasPicture_) throw std::invalid_argument("nothing has been drawn at this size yet");
  vtkOpenGLState* state = window_->GetState();
  state->PushReadFramebufferBinding();
  window_->GetDisplayFramebuffer()->Bind(GL_READ_FRAMEBUFFER);
  window_->GetDisplayFramebuffer()->ActivateReadBuffer(0);
  state->vtkglPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  state->PopReadFramebufferBinding();
  const std::ptrdiff_t rows = height_;
  for (std::ptrdiff_t y = 0; y < rows / 2; ++y) {
    const auto upper = pixels.begin() + y * width_;
    std::swap_ranges(upper, upper + width_, pixels.begin() + (rows - 1 - y) * width_);
  }
}

void CanvasScene::showPicture() {
  vtkOpenGLState* state = window_->GetState();
  state->PushFramebufferBindings();
  window_->GetDisplayFramebuffer()->Bind(GL_READ_FRAMEBUFFER);
  window_->GetDisplayFramebuffer()->ActivateReadBuffer(0);
  state->vtkglBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  state->vtkglDisable(GL_SCISSOR_TEST);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  state->PopFramebufferBindings();
}

void OverlayPainter::setImage(vtkOpenGLRenderWindow* window, ImageId image, int width, int height,
                              std::span<const Rgba> pixels) {
  vtkNew<vtkTextureObject>& texture = images_[image];
  const auto columns = static_cast<unsigned>(width);
  const auto rows = static_cast<unsigned>(height);
  if (texture->GetHandle() == 0 || texture->GetWidth() != columns || texture->GetHeight() != rows) {
    texture->SetContext(window);
    if (!texture->Allocate2D(columns, rows, 4, VTK_UNSIGNED_CHAR)) throw std::bad_alloc();
  }
  texture->Activate();
  window->GetState()->vtkglPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  texture->Deactivate();
}

void OverlayPainter::set(Overlay overlay) {
  overlay_ = std::move(overlay);
  uploaded_ = false;
}

// Copies the overlay to the bound vertex array, and assigns its data to the attributes of `program`.
void OverlayPainter::upload(vtkShaderProgram& program) {
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(overlay_.vertices.size() * sizeof(OverlayVertex)),
               overlay_.vertices.data(), GL_STREAM_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, corners_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(overlay_.corners.size() * sizeof(std::uint32_t)),
               overlay_.corners.data(), GL_STREAM_DRAW);
  const auto attribute = [&](const char* name, int size, GLenum type, std::size_t offset) {
    const auto index = static_cast<GLuint>(glGetAttribLocation(static_cast<GLuint>(program.GetHandle()), name));
    glEnableVertexAttribArray(index);
    glVertexAttribPointer(index, size, type, type == GL_FLOAT ? GL_FALSE : GL_TRUE, sizeof(OverlayVertex),
                          offsetPointer(offset));
  };
  attribute("pixel", 2, GL_FLOAT, offsetof(OverlayVertex, x));
  attribute("textureCoordinates", 2, GL_FLOAT, offsetof(OverlayVertex, u));
  attribute("color", 4, GL_UNSIGNED_BYTE, offsetof(OverlayVertex, color));
  uploaded_ = true;
}

void OverlayPainter::draw(vtkOpenGLRenderWindow* window, int width, int height) {
  if (overlay_.parts.empty()) return;
  vtkOpenGLState* state = window->GetState();
  vtkShaderProgram* program = window->GetShaderCache()->ReadyShaderProgram(kVertex, kFragment, "");
  if (program == nullptr) throw std::runtime_error("the shader of the canvas's overlay cannot be built");
  if (vertexArray_ == 0) {
    glGenVertexArrays(1, &vertexArray_);
    glGenBuffers(1, &vertices_);
    glGenBuffers(1, &corners_);
  }
  glBindVertexArray(vertexArray_);
  if (!uploaded_) upload(*program);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglDisable(GL_CULL_FACE);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglEnable(GL_BLEND);
  state->vtkglEnable(GL_SCISSOR_TEST);
  state->vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  state->vtkglViewport(0, 0, width, height);
  const float size[2] = {static_cast<float>(width), static_cast<float>(height)};
  program->SetUniform2f("canvasSize", size);
  for (const OverlayPart& part : overlay_.parts) {
    const PixelRect& clip = part.clip;
    if (clip.width <= 0 || clip.height <= 0 || part.count == 0) continue;
    vtkTextureObject* texture = images_.at(part.image);
    texture->Activate();
    program->SetUniformi("image", texture->GetTextureUnit());
    state->vtkglScissor(clip.left, height - clip.top - clip.height, clip.width, clip.height);
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(part.count), GL_UNSIGNED_INT,
                   offsetPointer(part.first * sizeof(std::uint32_t)));
    texture->Deactivate();
  }
  state->vtkglDisable(GL_SCISSOR_TEST);
  glBindVertexArray(0);
}

void OverlayPainter::release(vtkWindow* window) {
  for (auto& [id, texture] : images_) texture->ReleaseGraphicsResources(window);
  if (vertexArray_ == 0) return;
  glDeleteVertexArrays(1, &vertexArray_);
  glDeleteBuffers(1, &vertices_);
  glDeleteBuffers(1, &corners_);
  vertexArray_ = vertices_ = corners_ = 0;
}

}  // namespace scanmill
