#include "viewer/panels/imgui_layer.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <cstring>

#include "base/file.h"

namespace scanmill {

namespace {

constexpr ImageId kFontImage = 0xFFFFFFFF;

// Fonts of Debian's packages fonts-inter and fonts-dejavu-core. Without them, Dear ImGui's built-in font is used.
constexpr std::array<const char*, 2> kFonts{"/usr/share/fonts/opentype/inter/Inter-Regular.otf",
                                            "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"};

constexpr std::pair<std::string_view, ImGuiKey> kKeys[] = {{"Tab", ImGuiKey_Tab},
                                                           {"Left", ImGuiKey_LeftArrow},
                                                           {"Right", ImGuiKey_RightArrow},
                                                           {"Up", ImGuiKey_UpArrow},
                                                           {"Down", ImGuiKey_DownArrow},
                                                           {"Page_Up", ImGuiKey_PageUp},
                                                           {"Page_Down", ImGuiKey_PageDown},
                                                           {"Home", ImGuiKey_Home},
                                                           {"End", ImGuiKey_End},
                                                           {"BackSpace", ImGuiKey_Backspace},
                                                           {"Return", ImGuiKey_Enter},
                                                           {"Escape", ImGuiKey_Escape}};

ImVec4 colorOf(const Rgb& c, float alpha = 1) {
  return {static_cast<float>(c[0]) / 255, static_cast<float>(c[1]) / 255, static_cast<float>(c[2]) / 255, alpha};
}

// Sets the colours of a style. `colors`: one per value of ImGuiCol.
void setColors(ImVec4* colors) {
  constexpr Rgb kPanel{24, 27, 34}, kText{225, 228, 235}, kDim{152, 157, 168}, kBorder{66, 72, 86};
  constexpr Rgb kRaised{42, 47, 58}, kAccent{98, 168, 255};
  ImGui::StyleColorsDark();
  colors[ImGuiCol_Text] = colorOf(kText);
  colors[ImGuiCol_TextDisabled] = colorOf(kDim);
  colors[ImGuiCol_WindowBg] = colors[ImGuiCol_PopupBg] = colorOf(kPanel, 0.97F);
  colors[ImGuiCol_MenuBarBg] = colorOf(kPanel);
  colors[ImGuiCol_Border] = colorOf(kBorder);
  for (const ImGuiCol raised :
       {ImGuiCol_FrameBg, ImGuiCol_Button, ImGuiCol_TitleBg, ImGuiCol_TitleBgActive, ImGuiCol_TableHeaderBg}) {
    colors[raised] = colorOf(kRaised);
  }
  colors[ImGuiCol_Header] = colorOf(kRaised, 0.8F);
  for (const ImGuiCol hovered : {ImGuiCol_HeaderHovered, ImGuiCol_ButtonHovered, ImGuiCol_FrameBgHovered}) {
    colors[hovered] = colorOf(kAccent, 0.35F);
  }
  for (const ImGuiCol active : {ImGuiCol_HeaderActive, ImGuiCol_ButtonActive, ImGuiCol_FrameBgActive}) {
    colors[active] = colorOf(kAccent, 0.6F);
  }
  for (const ImGuiCol mark : {ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive, ImGuiCol_CheckMark}) {
    colors[mark] = colorOf(kAccent);
  }
}

// Adds the first font of kFonts that exists, with western letters, Greek and arrows, else the built-in font.
void addFont(ImFontAtlas& atlas, double lineHeight) {
  static const ImWchar kLetters[] = {0x20, 0xFF, 0x370, 0x3FF, 0x2010, 0x2026, 0x2190, 0x2193, 0x25B2, 0x25C0, 0};
  const auto size = static_cast<float>(std::round(lineHeight));
  for (const char* file : kFonts) {
    if (pathExists(file) && atlas.AddFontFromFileTTF(file, size, nullptr, kLetters)) return;
  }
  ImFontConfig config;
  config.SizePixels = size;
  atlas.AddFontDefault(&config);
}

// Dear ImGui 1.89 and later (Debian 13) receives keys as events, earlier versions (Debian 12) in io.KeysDown and flags.
#if IMGUI_VERSION_NUM >= 18900
void nameKeys(ImGuiIO&) {}

void setKey(ImGuiIO& io, ImGuiKey key, bool down) {
  io.AddKeyEvent(key, down);
}

void setModifiers(ImGuiIO& io, bool shift, bool control) {
  io.AddKeyEvent(ImGuiMod_Shift, shift);
  io.AddKeyEvent(ImGuiMod_Ctrl, control);
}
#else
void nameKeys(ImGuiIO& io) {
  for (const auto& [name, key] : kKeys) io.KeyMap[key] = key;
}

void setKey(ImGuiIO& io, ImGuiKey key, bool down) {
  io.KeysDown[key] = down;
}

void setModifiers(ImGuiIO& io, bool shift, bool control) {
  io.KeyShift = shift;
  io.KeyCtrl = control;
}
#endif

// Converts the triangles that Dear ImGui has drawn to an overlay of the canvas. Each draw list of Dear ImGui has its
// own vertices, to which the list's indices refer; the overlay has the vertices of all lists, one list after the other.
Overlay overlayOf(const ImDrawData& drawn, const Canvas& canvas) {
  static_assert(sizeof(ImDrawVert) == sizeof(OverlayVertex) &&
                offsetof(ImDrawVert, col) == offsetof(OverlayVertex, color));
  Overlay overlay;
  overlay.vertices.reserve(static_cast<std::size_t>(drawn.TotalVtxCount));
  overlay.corners.reserve(static_cast<std::size_t>(drawn.TotalIdxCount));
  for (int k = 0; k < drawn.CmdListsCount; ++k) {
    const ImDrawList& list = *drawn.CmdLists[k];
    const std::size_t firstVertex = overlay.vertices.size();
    const auto vertices = static_cast<std::size_t>(list.VtxBuffer.Size);
    overlay.vertices.resize(firstVertex + vertices);
    if (vertices > 0) {
      std::memcpy(static_cast<void*>(overlay.vertices.data() + firstVertex), list.VtxBuffer.Data,
                  vertices * sizeof(OverlayVertex));
    }
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;  // left, top, right and bottom
      const int left = std::max(static_cast<int>(clip.x), 0);
      const int top = std::max(static_cast<int>(clip.y), 0);
      const int width = std::min(static_cast<int>(clip.z), canvas.width()) - left;
      const int height = std::min(static_cast<int>(clip.w), canvas.height()) - top;
      overlay.parts.push_back({.clip = {left, top, width, height},
                               .image = static_cast<ImageId>(reinterpret_cast<std::uintptr_t>(command.GetTexID())),
                               .first = overlay.corners.size(),
                               .count = command.ElemCount});
      for (unsigned i = 0; i < command.ElemCount; ++i) {
        const ImDrawIdx index = list.IdxBuffer[static_cast<int>(command.IdxOffset + i)];
        overlay.corners.push_back(static_cast<std::uint32_t>(firstVertex + command.VtxOffset + index));
      }
    }
  }
  return overlay;
}

}  // namespace

ImGuiIO& ImGuiLayer::io() const {
  ImGui::SetCurrentContext(context_);
  return ImGui::GetIO();
}

ImGuiLayer::ImGuiLayer(Canvas& canvas, double lineHeight) : canvas_(canvas), context_(ImGui::CreateContext()) {
  ImGuiIO& io = this->io();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  io.ConfigInputTextCursorBlink = false;
  io.DeltaTime = 1.0F / 60;
  nameKeys(io);
  addFont(*io.Fonts, lineHeight);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  std::vector<Rgba> atlas(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::memcpy(atlas.data(), pixels, atlas.size() * sizeof(Rgba));
  canvas.setImage(kFontImage, width, height, atlas);
  io.Fonts->SetTexID(textureOf(kFontImage));
  ImGuiStyle& style = ImGui::GetStyle();
  constexpr double kUsualLineHeight = 14;  // line height for which Dear ImGui's sizes are made (pixels)
  style.ScaleAllSizes(static_cast<float>(lineHeight / kUsualLineHeight));
  style.WindowRounding = style.PopupRounding = style.ChildRounding = static_cast<float>(lineHeight / 3);
  style.FrameRounding = style.GrabRounding = style.ScrollbarRounding = static_cast<float>(lineHeight / 4);
  style.AntiAliasedLinesUseTex = false;
  style.WindowMenuButtonPosition = ImGuiDir_None;
  setColors(style.Colors);
}

ImGuiLayer::~ImGuiLayer() {
  ImGui::DestroyContext(context_);
}

double ImGuiLayer::lineHeight() const {
  return io().Fonts->Fonts.front()->FontSize;
}

double ImGuiLayer::row() const {
  return lineHeight() + 2.0 * ImGui::GetStyle().FramePadding.y;
}

void ImGuiLayer::take(const CanvasEvent& event) {
  using Kind = CanvasEvent::Kind;
  ImGuiIO& io = this->io();
  if (event.kind == Kind::Move || event.kind == Kind::Down || event.kind == Kind::Up || event.kind == Kind::Wheel) {
    io.MousePos = {static_cast<float>(event.x), static_cast<float>(event.y)};
    setModifiers(io, event.shift, event.control);
  }
  if (event.kind == Kind::Down || event.kind == Kind::Up) {
    constexpr std::array<int, 3> kButtons{0, 2, 1};  // Dear ImGui's indices of the left, middle and right button
    io.MouseDown[kButtons[static_cast<std::size_t>(std::clamp(event.button, 1, 3) - 1)]] = event.kind == Kind::Down;
    clicks_ = event.clicks;
  }
  if (event.kind == Kind::Wheel && std::isfinite(event.amount)) io.MouseWheel += static_cast<float>(event.amount);
  if (event.kind != Kind::Key) return;
  for (const auto& [name, key] : kKeys) {
    if (name != event.key) continue;
    setKey(io, key, true);
    pressedKeys_.push_back(key);
    return;
  }
  io.AddInputCharactersUTF8(event.text.c_str());
}

void ImGuiLayer::frame(const std::function<void()>& panels) {
  ImGuiIO& io = this->io();
  io.DisplaySize = {static_cast<float>(canvas_.width()), static_cast<float>(canvas_.height())};
  ImGui::NewFrame();
  panels();
  ImGui::Render();
  for (const int key : std::exchange(pressedKeys_, {})) setKey(io, static_cast<ImGuiKey>(key), false);
  canvas_.setOverlay(overlayOf(*ImGui::GetDrawData(), canvas_));
}

bool ImGuiLayer::hasPointer() const {
  return io().WantCaptureMouse;
}

bool ImGuiLayer::hasKeys() const {
  return io().WantTextInput;
}

bool ImGuiLayer::closeMenus() {
  ImGui::SetCurrentContext(context_);
  if (context_->OpenPopupStack.empty()) return false;
  ImGui::ClosePopupToLevel(0, true);
  return true;
}

bool ImGuiLayer::shift() const {
  return io().KeyShift;
}

void setImage(Canvas& canvas, ImageId image, const Image& picture) {
  std::vector<Rgba> pixels;
  pixels.reserve(picture.pixels.size());
  for (const Rgb& c : picture.pixels) pixels.push_back({c[0], c[1], c[2], 255});
  canvas.setImage(image, picture.width, picture.height, pixels);
}

void* textureOf(ImageId image) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): Dear ImGui's type of texture ids is a pointer
  return reinterpret_cast<void*>(std::uintptr_t{image});
}

}  // namespace scanmill
