#include "viewer/panels/imgui_layer.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

constexpr ImageId kFontImage = 0xFFFFFFFF;

// Font files in Debian's packages fonts-inter and fonts-dejavu-core. If neither exists, Dear ImGui's built-in font is
// used.
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

// Dear ImGui 1.89 and later (Debian 13) receive keys as events, earlier versions (Debian 12) in a table and flags.
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

}  // namespace

struct ImGuiLayer::State {
  Canvas& canvas;
  ImGuiContext* context;
  int clicks = 1;
  std::vector<ImGuiKey> pressed;  // keys to release after the next frame

  // Makes the context current.
  ImGuiIO& io() const {
    ImGui::SetCurrentContext(context);
    return ImGui::GetIO();
  }
};

ImGuiLayer::ImGuiLayer(Canvas& canvas, double lineHeight)
    : state_(std::make_unique<State>(State{canvas, ImGui::CreateContext(), 1, {}})) {
  ImGuiIO& io = state_->io();
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
  style.ScaleAllSizes(static_cast<float>(lineHeight / 14));
  style.WindowRounding = style.PopupRounding = style.ChildRounding = static_cast<float>(lineHeight / 3);
  style.FrameRounding = style.GrabRounding = style.ScrollbarRounding = static_cast<float>(lineHeight / 4);
  style.AntiAliasedLinesUseTex = false;
  style.WindowMenuButtonPosition = ImGuiDir_None;
  setColors(style.Colors);
}

ImGuiLayer::~ImGuiLayer() {
  ImGui::DestroyContext(state_->context);
}

double ImGuiLayer::lineHeight() const {
  return state_->io().Fonts->Fonts.front()->FontSize;
}

double ImGuiLayer::row() const {
  return lineHeight() + 2.0 * ImGui::GetStyle().FramePadding.y;
}

void ImGuiLayer::take(const CanvasEvent& event) {
  using Kind = CanvasEvent::Kind;
  ImGuiIO& io = state_->io();
  if (event.kind == Kind::Move || event.kind == Kind::Down || event.kind == Kind::Up || event.kind == Kind::Wheel) {
    io.MousePos = {static_cast<float>(event.x), static_cast<float>(event.y)};
    setModifiers(io, event.shift, event.control);
  }
  if (event.kind == Kind::Down || event.kind == Kind::Up) {
    constexpr std::array<int, 4> kButtons{0, 0, 2, 1};
    io.MouseDown[kButtons[static_cast<std::size_t>(std::clamp(event.button, 1, 3))]] = event.kind == Kind::Down;
    state_->clicks = event.clicks;
  }
  if (event.kind == Kind::Wheel && std::isfinite(event.amount)) io.MouseWheel += static_cast<float>(event.amount);
  if (event.kind != Kind::Key) return;
  for (const auto& [name, key] : kKeys) {
    if (name != event.key) continue;
    setKey(io, key, true);
    state_->pressed.push_back(key);
    return;
  }
  io.AddInputCharactersUTF8(event.text.c_str());
}

void ImGuiLayer::frame(const std::function<void()>& panels) {
  ImGuiIO& io = state_->io();
  io.DisplaySize = {static_cast<float>(state_->canvas.width()), static_cast<float>(state_->canvas.height())};
  ImGui::NewFrame();
  panels();
  ImGui::Render();
  for (const ImGuiKey key : std::exchange(state_->pressed, {})) setKey(io, key, false);

  static_assert(sizeof(ImDrawVert) == sizeof(OverlayVertex) &&
                offsetof(ImDrawVert, col) == offsetof(OverlayVertex, color));
  const ImDrawData& drawn = *ImGui::GetDrawData();
  Overlay overlay;
  overlay.vertices.resize(static_cast<std::size_t>(drawn.TotalVtxCount));
  overlay.corners.reserve(static_cast<std::size_t>(drawn.TotalIdxCount));
  std::size_t before = 0;
  for (int k = 0; k < drawn.CmdListsCount; ++k) {
    const ImDrawList& list = *drawn.CmdLists[k];
    const auto vertices = static_cast<std::size_t>(list.VtxBuffer.Size);
    if (vertices > 0) {
      std::memcpy(static_cast<void*>(overlay.vertices.data() + before), list.VtxBuffer.Data,
                  vertices * sizeof(OverlayVertex));
    }
    for (const ImDrawCmd& command : list.CmdBuffer) {
      OverlayPart part;
      part.first = overlay.corners.size();
      part.count = command.ElemCount;
      part.image = static_cast<ImageId>(reinterpret_cast<std::uintptr_t>(command.GetTexID()));
      const ImVec4& clip = command.ClipRect;
      const int left = std::max(static_cast<int>(clip.x), 0);
      const int top = std::max(static_cast<int>(clip.y), 0);
      part.clip = {left, top, std::min(static_cast<int>(clip.z), state_->canvas.width()) - left,
                   std::min(static_cast<int>(clip.w), state_->canvas.height()) - top};
      for (unsigned i = 0; i < command.ElemCount; ++i) {
        const ImDrawIdx index = list.IdxBuffer[static_cast<int>(command.IdxOffset + i)];
        overlay.corners.push_back(static_cast<std::uint32_t>(before + command.VtxOffset + index));
      }
      overlay.parts.push_back(part);
    }
    before += vertices;
  }
  state_->canvas.setOverlay(std::move(overlay));
}

bool ImGuiLayer::hasPointer() const {
  return state_->io().WantCaptureMouse;
}

bool ImGuiLayer::hasKeys() const {
  return state_->io().WantTextInput;
}

bool ImGuiLayer::closeMenus() {
  ImGui::SetCurrentContext(state_->context);
  if (state_->context->OpenPopupStack.empty()) return false;
  ImGui::ClosePopupToLevel(0, true);
  return true;
}

int ImGuiLayer::clicks() const {
  return state_->clicks;
}

bool ImGuiLayer::shift() const {
  return state_->io().KeyShift;
}

void setImage(Canvas& canvas, ImageId image, const Image& picture) {
  std::vector<Rgba> pixels;
  pixels.reserve(picture.pixels.size());
  for (const Rgb& c : picture.pixels) pixels.push_back({c[0], c[1], c[2], 255});
  canvas.setImage(image, picture.width, picture.height, pixels);
}

void* textureOf(ImageId image) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): a number where it wants a pointer
  return reinterpret_cast<void*>(std::uintptr_t{image});
}

}  // namespace scanmill
