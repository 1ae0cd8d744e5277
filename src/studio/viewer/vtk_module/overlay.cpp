#include "viewer/vtk_module/overlay.h"

#include <vtkOpenGLState.h>
#include <vtk_glew.h>

#include <algorithm>
#include <new>

namespace scanmill {

namespace {

constexpr const char* kFragment = R"(//VTK::System::Dec
//VTK::Output::Dec
uniform sampler2D image;
uniform int canvasHeight;

void main() {
  vec4 color = texelFetch(image, ivec2(gl_FragCoord.x, canvasHeight - 1 - int(gl_FragCoord.y)), 0);
  if (color.a == 0.0) discard;
  gl_FragData[0] = color;
}
)";

constexpr int kTile = 64;  // px

}  // namespace

Overlay::Overlay() : shader_(kFragment) {}

void Overlay::set(vtkOpenGLRenderWindow* window, int width, int height, std::span<const Rgba> pixels) {
  runs_.clear();
  const auto columns = static_cast<unsigned>(width);
  const auto rows = static_cast<unsigned>(height);
  if (texture_->GetHandle() == 0 || texture_->GetWidth() != columns || texture_->GetHeight() != rows) {
    texture_->SetContext(window);
    if (!texture_->Allocate2D(columns, rows, 4, VTK_UNSIGNED_CHAR)) throw std::bad_alloc();
  }
  texture_->Activate();
  window->GetState()->vtkglPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  texture_->Deactivate();

  // Most of it is transparent as a rule, and what is not drawn costs nothing.
  for (int top = 0; top < height; top += kTile) {
    const int tileHeight = std::min(kTile, height - top);
    for (int left = 0; left < width; left += kTile) {
      const int tileWidth = std::min(kTile, width - left);
      unsigned alpha = 0;
      for (int y = top; y < top + tileHeight; ++y) {
        const Rgba* row = &pixels[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(left)];
        for (int x = 0; x < tileWidth; ++x) alpha |= row[x][3];
      }
      if (alpha == 0) continue;
      const bool goesOn = !runs_.empty() && runs_.back().top == top && runs_.back().left + runs_.back().width == left;
      if (goesOn) {
        runs_.back().width += tileWidth;
      } else {
        runs_.push_back({left, top, tileWidth, tileHeight});
      }
    }
  }
}

void Overlay::draw(vtkOpenGLRenderWindow* window, int width, int height) {
  if (runs_.empty()) return;
  vtkOpenGLState* state = window->GetState();
  state->vtkglDisable(GL_SCISSOR_TEST);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglEnable(GL_BLEND);
  state->vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  vtkShaderProgram* program = shader_.ready(window);
  texture_->Activate();
  program->SetUniformi("image", texture_->GetTextureUnit());
  program->SetUniformi("canvasHeight", height);
  for (const PixelRun& run : runs_) {
    const int right = std::min(run.left + run.width, width);
    const int bottom = std::min(run.top + run.height, height);
    if (right <= run.left || bottom <= run.top) continue;
    state->vtkglViewport(run.left, height - bottom, right - run.left, bottom - run.top);
    shader_.draw();
  }
  texture_->Deactivate();
}

void Overlay::release(vtkWindow* window) {
  shader_.release();
  texture_->ReleaseGraphicsResources(window);
}

}  // namespace scanmill
