// The plug-in libscanmill_passes.so: VTK with its own OpenGL context, with the interface of passes/vtk/vtk_interface.h.

#include <fmt/format.h>
#include <vtkAutoInit.h>
#include <vtkNew.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLState.h>
#include <vtkTextureObject.h>
#include <vtk_glew.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "gpu/device.h"
#include "gpu/opengl_module/egl_context.h"
#include "gpu/opengl_module/gl_objects.h"
#include "gpu/opengl_module/gl_thread.h"
#include "gpu/opengl_module/gl_window.h"
#include "passes/vtk/vtk_interface.h"

VTK_MODULE_INIT(vtkRenderingOpenGL2)

namespace scanmill {

namespace {

// Locations of the vertex attributes; the shaders have the same numbers.
enum VertexAttribute : GLuint { kPosition = 0, kRows = 1, kFirstNumber = 4, kUv = 5, kCutout = 6 };
// Bindings of the shaders' storage buffers.
enum StorageBinding : GLuint { kCutouts = 0, kWords = 1 };

// The depth buffer contains the near clipping distance divided by w: the value decreases with distance. The relative
// precision of float32 is the same for small and large numbers, so the relative precision of the depth is the same near
// and far (Reed, "Depth precision visualized", 2015). There is no far clipping plane. If clip space has depths from -1
// to 1, OpenGL's mapping to 0 to 1 loses precision. Solid triangles have no textureUv and no cutoutIndex.
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

// Selects the texel that Texture::texel selects: the nearest texel of the repeated texture.
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

// The scene's triangles on the device.
class TriangleStore {
 public:
  TriangleStore(const ViewGeometry& scene) {
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
    cut_.add({.location = kCutout,
              .buffer = &cutCutouts_,
              .components = 1,
              .integer = true,
              .stride = sizeof(std::uint32_t)});
    checkGl("the scene's triangles cannot be uploaded");
  }

  // Uploads the placements that the following calls of draw() use.
  void uploadPlacements(std::span<const VtkPlacement> placements) {
    placements_.fill(placements.data(), placements.size_bytes(), GL_STREAM_DRAW);
  }

  // Draws triangles of the batch with cut-outs if `cut` is true, otherwise of the solid batch, by the current program.
  void draw(bool cut, std::span<const VtkDraw> draws) {
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

 private:
  GlBuffer solidPositions_;
  GlBuffer cutPositions_;
  GlBuffer cutUvs_;
  GlBuffer cutCutouts_;
  GlBuffer cutouts_;
  GlBuffer cutoutWords_;
  GlBuffer placements_;
  GlBuffer commands_;
  GlVertexArray solid_;
  GlVertexArray cut_;
};

// Renders images of triangle numbers: each pixel gets the number of the triangle that is visible at the pixel. The
// context of `window` must be current at each call.
class ImagePass {
 public:
  // Renders an image of `triangles` into the texture of `slot`.
  void draw(vtkOpenGLRenderWindow* window, TriangleStore& triangles, const VtkImage& image, std::uint32_t slot) {
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

  // Returns the texture of a slot; its values are the numbers of triangles.
  vtkTextureObject* numbers(std::uint32_t slot) const { return slots_[slot]; }

  void releaseGraphicsResources(vtkOpenGLRenderWindow* window) {
    solid_.reset();
    cut_.reset();
    frame_->ReleaseGraphicsResources(window);
    depth_->ReleaseGraphicsResources(window);
    for (const auto& slot : slots_) slot->ReleaseGraphicsResources(window);
  }

 private:
  void compilePrograms(vtkOpenGLRenderWindow* window) {
    using Shaders = std::initializer_list<GlShaderText>;
    zeroToOne_ = GLEW_VERSION_4_5 || GLEW_ARB_clip_control;
    solid_ = std::make_unique<GlProgram>("solid",
                                         Shaders{{GL_VERTEX_SHADER, kVertex}, {GL_FRAGMENT_SHADER, kSolidFragment}});
    cut_ = std::make_unique<GlProgram>("cut-out",
                                       Shaders{{GL_VERTEX_SHADER, kVertex}, {GL_FRAGMENT_SHADER, kCutFragment}});
    frame_->SetContext(window);
  }

  // Gives the texture `numbers` the size of the image, unless it has this size. Enlarges the depth buffer, which all
  // images share, if the buffer is too small.
  void prepareTextures(vtkOpenGLRenderWindow* window, const VtkImage& image, vtkTextureObject* numbers) {
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

  bool zeroToOne_ = false;  // true if depths in clip space are from 0 to 1; set by compilePrograms()
  std::unique_ptr<GlProgram> solid_;
  std::unique_ptr<GlProgram> cut_;
  vtkNew<vtkOpenGLFramebufferObject> frame_;
  vtkNew<vtkTextureObject> depth_;
  std::array<vtkNew<vtkTextureObject>, kVtkImages> slots_;
};

constexpr std::uint32_t kGroup = 64;                              // local_size_x of kGather
constexpr std::size_t kMostAtOnce = std::size_t{kGroup} * 65535;  // most addresses per dispatch; OpenGL guarantees
                                                                  // 65535 groups

// Reads pixels from several images. Loops over all images, because all invocations must use the same sampler index.
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

// Reads pixels of images back.
class GlPixelReader {
 public:
  GlPixelReader() : program_("gather", {{GL_COMPUTE_SHADER, kGather}}) {}

  // Implements VtkDevice::gather(). `images`: the textures of all slots.
  void gather(const std::array<vtkTextureObject*, kVtkImages>& images, const VtkPixels& pixels,
              std::span<const std::uint32_t> addresses, std::uint32_t* numbers) {
    std::array<GLint, kVtkImages> units{};
    GLuint imageCount = 0;
    for (std::size_t k = 0; k < kVtkImages; ++k) {
      if (images[k]->GetHandle() == 0 || pixels.firsts[k] == pixels.firsts[k + 1]) continue;
      images[k]->Activate();
      units[k] = images[k]->GetTextureUnit();
      imageCount = static_cast<GLuint>(k + 1);
    }
    program_.use();
    glUniform1iv(program_.uniform("images"), kVtkImages, units.data());
    glUniform1uiv(program_.uniform("firsts"), kVtkImages + 1, pixels.firsts);
    glUniform1uiv(program_.uniform("widths"), kVtkImages, pixels.widths);
    glUniform1ui(program_.uniform("imageCount"), imageCount);
    while (!addresses.empty()) {
      const std::size_t count = std::min(addresses.size(), kMostAtOnce);
      const std::size_t bytes = count * sizeof(std::uint32_t);
      addresses_.fill(addresses.data(), bytes, GL_STREAM_DRAW);
      numbers_.reserve(bytes, GL_STREAM_READ);
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, addresses_.name());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, numbers_.name());
      glUniform1ui(program_.uniform("count"), static_cast<GLuint>(count));
      glDispatchCompute(static_cast<GLuint>((count + kGroup - 1) / kGroup), 1, 1);
      glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      glBindBuffer(GL_COPY_READ_BUFFER, numbers_.name());
      glGetBufferSubData(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(bytes), numbers);
      addresses = addresses.subspan(count);
      numbers += count;
    }
    glUseProgram(0);
    for (vtkTextureObject* image : images) {
      if (image->GetHandle() != 0) image->Deactivate();
    }
    checkGl("pixels cannot be read back");
  }

 private:
  GlProgram program_;
  GlBuffer addresses_;
  GlBuffer numbers_;
};

// An OpenGL context and the objects that render in it. The objects are created and used while the context is current.
struct ContextState {
  explicit ContextState(const std::string& device) : context(device) {
    window->start(8, 8);  // images are drawn into textures, not into the window
    if (!GLEW_VERSION_4_3) throw NoDevice("VTK does not find OpenGL 4.3");
    reader = std::make_unique<GlPixelReader>();
  }
  ~ContextState() {
    triangles.reset();
    reader.reset();
    pass.releaseGraphicsResources(window);
    window->Finalize();
  }
  ContextState& operator=(ContextState&&) = delete;  // neither copied nor moved

  EglContext context;
  vtkNew<GlWindow> window;
  ImagePass pass;
  std::unique_ptr<TriangleStore> triangles;
  std::unique_ptr<GlPixelReader> reader;
};

class GlDevice final : public VtkDevice {
 public:
  explicit GlDevice(const std::string& device) {
    thread_->run([&] {
      Quiet quiet;
      auto state = std::make_unique<ContextState>(device);
      GLint size = 0;
      glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
      limits_ = {.imageSize = static_cast<std::uint32_t>(size),
                 .trianglesPerBatch = 0x7FFFFFFFu / 3};  // OpenGL's vertex indices are signed
      name_ = describeGl();
      state_ = std::move(state);
    });
  }

  ~GlDevice() override {
    thread_->run([&]() noexcept {
      Quiet quiet;
      state_->context.tryMakeCurrent();
      state_.reset();
    });
  }
  GlDevice& operator=(GlDevice&&) = delete;  // neither copied nor moved

  std::string name() const override { return name_; }
  VtkLimits limits() const override { return limits_; }

  void upload(const ViewGeometry& scene) override {
    withContext([&](ContextState& state) { state.triangles = std::make_unique<TriangleStore>(scene); });
  }

  void draw(std::uint32_t slot, const VtkImage& image) override {
    withContext([&](ContextState& state) { state.pass.draw(state.window, *state.triangles, image, slot); });
  }

  void finish() override {
    withContext([](ContextState&) { glFinish(); });
  }

  void gather(const VtkPixels& pixels, std::span<const std::uint32_t> addresses, std::uint32_t* numbers) override {
    withContext([&](ContextState& state) {
      std::array<vtkTextureObject*, kVtkImages> images{};
      for (std::uint32_t slot = 0; slot < kVtkImages; ++slot) images[slot] = state.pass.numbers(slot);
      state.reader->gather(images, pixels, addresses, numbers);
    });
  }

 private:
  // Calls `work` on the OpenGL thread, with the context current and without VTK's messages.
  template <class Work>
  void withContext(const Work& work) {
    thread_->run([&] {
      Quiet quiet;
      state_->context.makeCurrent();
      work(*state_);
      quiet.check();
    });
  }

  std::shared_ptr<GlThread> thread_ = GlThread::shared();
  std::unique_ptr<ContextState> state_;
  std::string name_;
  VtkLimits limits_;
};

class GlVtkModule final : public VtkModule {
 public:
  std::unique_ptr<VtkDevice> open(const std::string& device) const override {
    return std::make_unique<GlDevice>(device);
  }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(VtkModule, GlVtkModule)
