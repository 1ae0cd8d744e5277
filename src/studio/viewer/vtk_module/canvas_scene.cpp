#include "viewer/vtk_module/canvas_scene.h"

#include <fmt/format.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLState.h>
#include <vtk_glew.h>

#include <algorithm>
#include <new>
#include <optional>
#include <stdexcept>

namespace scanmill {

namespace {

void checkSize(std::uint32_t width, std::uint32_t height) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  const auto limit = static_cast<std::uint32_t>(std::max(most, 0));
  if (width < 1 || height < 1 || width > limit || height > limit) {
    throw std::invalid_argument(
        fmt::format("a canvas of {} x {} pixels cannot be drawn: take 1 to {} a side", width, height, limit));
  }
}

}  // namespace

CanvasScene::CanvasScene(std::uint32_t width, std::uint32_t height) : width_(width), height_(height) {
  checkSize(width, height);
  window_->start(static_cast<int>(width), static_cast<int>(height));
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

void CanvasScene::resize(std::uint32_t width, std::uint32_t height) {
  if (width == width_ && height == height_) return;
  checkSize(width, height);
  width_ = width;
  height_ = height;
  pictured_ = false;
  window_->SetSize(static_cast<int>(width), static_cast<int>(height));
  placeViews();
}

void CanvasScene::setViews(std::span<const ScanmillCanvasView> views) {
  if (views.size() > kCanvasViews) {
    throw std::invalid_argument(fmt::format("a canvas has at most {} views", kCanvasViews));
  }
  for (const ScanmillCanvasView& view : views) {
    const bool inside = view.width > 0 && view.height > 0 && view.left < width_ && view.top < height_ &&
                        view.width <= width_ - view.left && view.height <= height_ - view.top;
    if (!inside) throw std::invalid_argument("a view lies outside of its canvas");
    if (!(view.focal > 0) || !(view.nearest < view.farthest) || (view.orthographic == 0 && !(view.nearest > 0))) {
      throw std::invalid_argument("a view of the canvas has no camera");
    }
  }
  views_.assign(views.begin(), views.end());
  placeViews();
}

void CanvasScene::placeViews() {
  drawn_ = false;
  const int width = static_cast<int>(width_);
  const int height = static_cast<int>(height_);
  // In this order: the black is laid first.
  if (window_->HasRenderer(uncovered_) == 0) window_->AddRenderer(uncovered_);
  for (std::size_t k = 0; k < renderers_.size(); ++k) {
    const bool used = k < views_.size() && views_[k].left < width_ && views_[k].top < height_;
    const bool there = window_->HasRenderer(renderers_[k]) != 0;
    if (used) renderers_[k]->setView(views_[k], width, height);
    if (used && !there) window_->AddRenderer(renderers_[k]);
    if (!used && there) window_->RemoveRenderer(renderers_[k]);
  }
}

Item& CanvasScene::item(std::uint32_t number) {
  const auto found = items_.find(number);
  if (found == items_.end()) throw std::invalid_argument(fmt::format("the canvas has no item {}", number));
  return *found->second;
}

void CanvasScene::set(std::uint32_t number, ItemKind kind, std::uint64_t count, const float* positions,
                      const std::uint8_t* colors) {
  drawn_ = false;
  std::unique_ptr<Item>& slot = items_[number];
  std::optional<ScanmillCanvasLook> look;
  if (slot != nullptr && slot->kind() != kind) {
    look = slot->look();
    remove(*slot);
    slot.reset();
  }
  if (slot == nullptr) {
    slot = std::make_unique<Item>(kind);
    if (look) slot->setLook(*look);
    place(*slot);
  }
  slot->set(count, positions, colors);
}

void CanvasScene::setColors(std::uint32_t number, const std::uint8_t* colors) {
  drawn_ = false;
  item(number).setColors(colors);
}

void CanvasScene::show(std::uint32_t number, const std::uint32_t* indices, std::uint64_t count) {
  drawn_ = false;
  if (indices == nullptr) {
    item(number).show({});
  } else {
    item(number).show(std::vector<std::uint32_t>(indices, indices + count));
  }
}

void CanvasScene::setLook(std::uint32_t number, const ScanmillCanvasLook& look) {
  drawn_ = false;
  Item& changed = item(number);
  changed.setLook(look);
  place(changed);
}

void CanvasScene::drop(std::uint32_t number) {
  const auto found = items_.find(number);
  if (found == items_.end()) return;
  drawn_ = false;
  remove(*found->second);
  items_.erase(found);
}

// Into the views that it is in, and out of the others.
void CanvasScene::place(Item& item) {
  for (std::uint32_t k = 0; k < kCanvasViews; ++k) {
    const bool wanted = (item.look().views >> k & 1u) != 0;
    for (vtkActor* actor : item.actors()) {
      const bool there = renderers_[k]->HasViewProp(actor) != 0;
      if (wanted && !there) renderers_[k]->AddActor(actor);
      if (!wanted && there) renderers_[k]->RemoveActor(actor);
    }
  }
}

void CanvasScene::remove(Item& item) {
  for (const auto& renderer : renderers_) {
    for (vtkActor* actor : item.actors()) {
      if (renderer->HasViewProp(actor) != 0) renderer->RemoveActor(actor);
    }
  }
}

void CanvasScene::setOverlay(std::uint32_t width, std::uint32_t height, const std::uint8_t* rgba) {
  checkSize(std::max(width, 1u), std::max(height, 1u));
  overlay_.set(window_, width, height, rgba);
}

// VTK draws the views to one framebuffer, where they stay, and copies them to another; there the overlay is laid over.
void CanvasScene::draw(std::uint64_t mostPoints) {
  vtkOpenGLState* state = window_->GetState();
  if (!drawn_ || drawnPoints_ != mostPoints) {
    for (auto& [number, item] : items_) item->choose(mostPoints);
    window_->Render();
    drawn_ = true;
    drawnPoints_ = mostPoints;
  }
  state->Push();
  state->PushFramebufferBindings();
  const auto width = static_cast<GLint>(width_);
  const auto height = static_cast<GLint>(height_);
  window_->GetRenderFramebuffer()->Bind(GL_READ_FRAMEBUFFER);
  window_->GetRenderFramebuffer()->ActivateReadBuffer(0);
  window_->GetDisplayFramebuffer()->Bind(GL_DRAW_FRAMEBUFFER);
  window_->GetDisplayFramebuffer()->ActivateDrawBuffer(0);
  state->vtkglDisable(GL_SCISSOR_TEST);
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  overlay_.draw(window_, width, height);
  state->PopFramebufferBindings();
  state->Pop();
  pictured_ = true;
}

void CanvasScene::read(std::uint8_t* rgb) {
  if (!pictured_) throw std::invalid_argument("nothing has been drawn at this size yet");
  vtkOpenGLState* state = window_->GetState();
  state->PushReadFramebufferBinding();
  window_->GetDisplayFramebuffer()->Bind(GL_READ_FRAMEBUFFER);
  window_->GetDisplayFramebuffer()->ActivateReadBuffer(0);
  state->vtkglPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_), GL_RGB, GL_UNSIGNED_BYTE, rgb);
  state->PopReadFramebufferBinding();
  const std::size_t row = std::size_t{3} * width_;
  for (std::size_t y = 0; y < height_ / 2; ++y) {
    std::swap_ranges(rgb + y * row, rgb + (y + 1) * row, rgb + (height_ - 1 - y) * row);
  }
}

void CanvasScene::showPicture() {
  vtkOpenGLState* state = window_->GetState();
  state->PushFramebufferBindings();
  window_->GetDisplayFramebuffer()->Bind(GL_READ_FRAMEBUFFER);
  window_->GetDisplayFramebuffer()->ActivateReadBuffer(0);
  state->vtkglBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  state->vtkglDisable(GL_SCISSOR_TEST);
  const auto width = static_cast<GLint>(width_);
  const auto height = static_cast<GLint>(height_);
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  state->PopFramebufferBindings();
}

}  // namespace scanmill
