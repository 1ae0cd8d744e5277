#include "viewer/panels/widgets.h"

#include <fmt/core.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/short_text.h"
#include "viewer/color_map.h"
#include "viewer/panels/panel_rects.h"

namespace scanmill {

void textLine(const std::string& text) {
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

void dimText(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  textLine(text);
  ImGui::PopStyleColor();
}

namespace {

constexpr Rgb kAlarm{240, 72, 60};
constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoCollapse |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav;
constexpr ImGuiWindowFlags kMessage = kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing;

ImU32 packed(const Rgb& c, int alpha = 255) {
  return IM_COL32(c[0], c[1], c[2], alpha);
}

float lineHeight() {
  return ImGui::GetFontSize();
}

ImVec2 sizeOf(const std::string& text, float wrap = -1) {
  return ImGui::CalcTextSize(text.data(), text.data() + text.size(), false, wrap);
}

void drawWrapped(void (*draw)(const std::string&), const std::string& text) {
  ImGui::PushTextWrapPos(0);
  draw(text);
  ImGui::PopTextWrapPos();
}

// Returns the text; if it is wider than `width` pixels, only as much of its beginning as fits, followed by "...".
std::string fitted(const std::string& text, float width) {
  if (sizeOf(text).x <= width) return text;
  const float dots = sizeOf("...").x;
  std::size_t kept = text.size();
  const auto inLetter = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; };
  // First halve the text repeatedly, since it may be very long.
  while (kept > 64 && sizeOf(text.substr(0, kept / 2)).x > width) kept /= 2;
  while (kept > 0 && (sizeOf(text.substr(0, kept)).x + dots > width || (kept < text.size() && inLetter(kept)))) --kept;
  return text.substr(0, kept) + "...";
}

void swatch(const ImVec2& at, const Rgb& color, bool filled) {
  const float side = std::floor(lineHeight() * 0.75F);
  const ImVec2 corner{std::floor(at.x), std::floor(at.y + (lineHeight() - side) / 2)};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, {corner.x + side, corner.y + side}, packed(filled ? color : mix(color, kNoValue, 0.4)));
  if (filled) return;
  const float edge = std::max(std::floor(side / 6), 1.0F);
  list.AddRectFilled({corner.x + edge, corner.y + edge}, {corner.x + side - edge, corner.y + side - edge},
                     ImGui::GetColorU32(ImGuiCol_WindowBg, 1000));
}

struct LegendRow {
  std::string name;
  std::string count;
  Rgb color{};
  enum class Look { Shown, Absent, Partly, Hidden } look = Look::Shown;
};

// Draws a row of a legend. Returns true if the user has clicked the row.
bool legendRow(int id, const LegendRow& row, bool clickable, float width) {
  using Look = LegendRow::Look;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  bool pressed = false;
  ImGui::PushID(id);
  if (clickable) {
    ImGui::InvisibleButton("row", {std::max(width, 1.0F), lineHeight() + 2});
    pressed = ImGui::IsItemActivated();
    if (ImGui::IsItemHovered()) {
      ImGui::GetWindowDrawList()->AddRectFilled({at.x - 2, at.y}, {at.x + width, at.y + lineHeight() + 2},
                                                ImGui::GetColorU32(ImGuiCol_HeaderHovered), 3);
    }
  } else {
    ImGui::Dummy({std::max(width, 1.0F), lineHeight() + 2});
  }
  ImGui::PopID();
  swatch({at.x, at.y + 1}, row.color, row.look == Look::Shown || row.look == Look::Absent);
  const ImU32 color = ImGui::GetColorU32(row.look == Look::Shown ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  const float count = row.count.empty() ? 0 : sizeOf(row.count).x + lineHeight() * 0.5F;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float left = at.x + lineHeight() * 1.25F;
  const std::string name = fitted(row.name, width - lineHeight() * 1.25F - count);
  if (name != row.name && ImGui::IsMouseHoveringRect(at, {at.x + width, at.y + lineHeight() + 2})) {
    ImGui::SetTooltip("%s", row.name.c_str());
  }
  list.AddText({left, at.y + 1}, color, name.data(), name.data() + name.size());
  if (row.look == Look::Hidden) {
    list.AddLine({left, at.y + 1 + lineHeight() * 0.55F}, {left + sizeOf(name).x, at.y + 1 + lineHeight() * 0.55F},
                 color);
  }
  if (count > 0) {
    list.AddText({at.x + width - count + lineHeight() * 0.5F, at.y + 1}, ImGui::GetColorU32(ImGuiCol_TextDisabled),
                 row.count.data(), row.count.data() + row.count.size());
  }
  return pressed;
}

}  // namespace

void panelAt(const char* name, const PixelRect& rect, PanelUse use, const std::function<void()>& body) {
  if (rect.width < 1 || rect.height < 1) return;
  ImGui::SetNextWindowPos({static_cast<float>(rect.left), static_cast<float>(rect.top)});
  ImGui::SetNextWindowSize({static_cast<float>(rect.width), static_cast<float>(rect.height)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  const ImGuiWindowFlags still =
      use == PanelUse::Interactive ? 0 : ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse;
  if (ImGui::Begin(name, nullptr, kFixed | still)) body();
  ImGui::End();
  ImGui::PopStyleVar(3);
}

void titleRow(const PixelRect& rect, const std::string& left, const std::string& right) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding,
                      {lineHeight() * 0.6F, std::max(static_cast<float>(rect.height) - lineHeight(), 0.0F) / 2});
  panelAt("##title", rect, PanelUse::Picture, [&] {
    const float room = ImGui::GetContentRegionAvail().x;
    const std::string shown = fitted(left, room);
    textLine(shown);
    const float wide = sizeOf(right).x;
    if (wide + sizeOf(shown).x + lineHeight() > room) return;
    ImGui::SameLine(ImGui::GetCursorPosX() + room - wide);
    dimText(right);
  });
  ImGui::PopStyleVar();
}

void section(const std::string& title, PanelUse use, const std::function<void()>& body) {
  ImGui::PushID(title.c_str());
  if (use == PanelUse::Picture) {
    drawWrapped(dimText, title);
    body();
    ImGui::Dummy({1, lineHeight() * 0.4F});
  } else if (ImGui::CollapsingHeader(title.c_str(), ImGuiTreeNodeFlags_DefaultOpen)) {
    body();
  }
  ImGui::PopID();
}

void drawLabels(const std::vector<PanelLabel>& labels) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float away = lineHeight() * 0.5F;
  std::vector<ImVec4> drawn;  // left, top, right and bottom of the texts
  for (const PanelLabel& label : labels) {
    const ImVec2 at{static_cast<float>(label.x), static_cast<float>(label.y)};
    const auto left = static_cast<float>(label.within.left), width = static_cast<float>(label.within.width);
    if (label.mark) {
      list.AddCircle(at, lineHeight() * 0.45F, packed({0, 0, 0}), 0, lineHeight() * 0.25F);
      list.AddCircle(at, lineHeight() * 0.45F, packed({255, 255, 255}), 0, lineHeight() * 0.12F);
    }
    if (label.text.empty()) continue;
    const std::string text = fitted(label.text, width - 2 * away);
    const ImVec2 size = sizeOf(text);
    // If the text would extend beyond the view, draw it on the other side of the mark.
    float x = at.x + 2 * away;
    if (x + size.x + away > left + width) x = std::max(at.x - 2 * away - size.x, left + away);
    float y = at.y - away - size.y;
    if (y < static_cast<float>(label.within.top) + away) y = at.y + 2 * away;
    const ImVec4 area{x - 3, y - 1, x + size.x + 3, y + size.y + 1};
    const auto overlaps = [&](const ImVec4& other) {
      return area.x < other.z && other.x < area.z && area.y < other.w && other.y < area.w;
    };
    if (label.optional && std::ranges::any_of(drawn, overlaps)) continue;
    drawn.push_back(area);
    list.AddRectFilled({area.x, area.y}, {area.z, area.w}, packed(kBackground, 200), 3);
    list.AddText({std::floor(x), std::floor(y)}, packed({255, 255, 255}), text.data(), text.data() + text.size());
  }
}

void drawCaption(const PixelRect& view, const std::string& text, bool active) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 corner{static_cast<float>(view.left), static_cast<float>(view.top)};
  const ImVec2 end{corner.x + static_cast<float>(view.width), corner.y + static_cast<float>(view.height)};
  const float inset = lineHeight() * 0.5F;
  if (active) list.AddRect(corner, end, ImGui::GetColorU32(ImGuiCol_CheckMark), 0, 0, std::max(lineHeight() / 8, 2.0F));
  const std::string shown = fitted(text, static_cast<float>(view.width) - 4 * inset);
  if (text.empty() || static_cast<float>(view.height) < 3 * lineHeight()) return;
  const ImVec2 at{corner.x + inset, corner.y + inset};
  const ImVec2 size = sizeOf(shown);
  list.AddRectFilled(at, {at.x + size.x + 2 * inset, at.y + size.y + inset}, ImGui::GetColorU32(ImGuiCol_WindowBg), 4);
  list.AddText({at.x + inset, at.y + inset / 2}, ImGui::GetColorU32(ImGuiCol_Text), shown.data(),
               shown.data() + shown.size());
}

void drawMessage(const PixelRect& view, const std::string& text) {
  constexpr float kLarge = 1.5F;
  const float size = lineHeight() * kLarge;
  const float room = std::min(static_cast<float>(view.width) - 4 * size, 40 * size);
  if (text.empty() || room < size) return;
  const ImVec2 extent = ImGui::GetFont()->CalcTextSizeA(size, room, room, text.data(), text.data() + text.size());
  const ImVec2 at{std::floor(static_cast<float>(view.left) + (static_cast<float>(view.width) - extent.x) / 2),
                  std::floor(static_cast<float>(view.top) + (static_cast<float>(view.height) - extent.y) / 2)};
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled({at.x - size, at.y - size / 2}, {at.x + extent.x + size, at.y + extent.y + size / 2},
                     ImGui::GetColorU32(ImGuiCol_WindowBg), size / 3);
  list.AddText(ImGui::GetFont(), size, at, ImGui::GetColorU32(ImGuiCol_Text), text.data(), text.data() + text.size(),
               room);
}

LegendUse legendRows(const Legend& legend, const std::vector<bool>& hidden, bool clickable, PanelUse panel) {
  using Look = LegendRow::Look;
  const bool still = panel == PanelUse::Picture;
  LegendUse use;
  const auto isHidden = [&](std::size_t i) { return i < hidden.size() && hidden[i]; };
  std::uint64_t points = 0;
  std::size_t gone = 0;
  for (std::size_t i = 0; i < legend.entries.size(); ++i) {
    points += legend.entries[i].points;
    gone += isHidden(i) ? 1 : 0;
  }
  const auto count = [&](std::uint64_t n) { return points > 0 ? grouped(n) : std::string(); };
  const float width = ImGui::GetContentRegionAvail().x;
  if (clickable && !still && legend.entries.size() > 1) {
    const Look look = gone == 0 ? Look::Shown : gone < legend.entries.size() ? Look::Partly : Look::Hidden;
    const ImVec4 text = ImGui::GetStyleColorVec4(ImGuiCol_Text);
    const auto byte = [](float share) { return static_cast<std::uint8_t>(std::lround(share * 255)); };
    use.all = legendRow(-1, {"all", count(points), {byte(text.x), byte(text.y), byte(text.z)}, look}, true, width);
  }
  const float high = lineHeight() + 2 + ImGui::GetStyle().ItemSpacing.y;
  const float room = ImGui::GetContentRegionAvail().y;
  const auto absent = [&](const LegendEntry& entry) { return points > 0 && entry.points == 0; };
  std::size_t left = legend.entries.size();  // number of entries that are not drawn yet
  if (still) left -= static_cast<std::size_t>(std::ranges::count_if(legend.entries, absent));
  auto lines = still ? static_cast<std::size_t>(std::max(room / high, 0.0F)) : left;
  if (lines < left && lines > 0) --lines;  // one line is needed for the number of omitted entries
  for (std::size_t i = 0; i < legend.entries.size() && lines > 0; ++i) {
    const LegendEntry& entry = legend.entries[i];
    if (still && absent(entry)) continue;
    --lines;
    --left;
    const Look look = isHidden(i) ? Look::Hidden : absent(entry) ? Look::Absent : Look::Shown;
    if (legendRow(static_cast<int>(i), {entry.name, count(entry.points), entry.color, look}, clickable, width)) {
      use.entry = i;
    }
  }
  if (left > 0) dimText(fmt::format("+ {} more", left));
  return use;
}

std::optional<ScaleRange> scaleBar(const Legend& legend, PanelUse use) {
  constexpr int kSteps = 64;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const float high = std::floor(lineHeight() * 0.9F);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  for (int i = 0; i < kSteps; ++i) {
    const ImU32 from = packed(viridis(static_cast<double>(i) / kSteps));
    const ImU32 to = packed(viridis(static_cast<double>(i + 1) / kSteps));
    list.AddRectFilledMultiColor({at.x + width * static_cast<float>(i) / kSteps, at.y},
                                 {at.x + width * static_cast<float>(i + 1) / kSteps, at.y + high}, from, to, to, from);
  }
  float free = at.x;  // left end of the part of the bar below which no number has been written
  for (const auto& [position, text] : scaleTicks(legend)) {
    const float x = at.x + width * static_cast<float>(position);
    const float wide = sizeOf(text).x;
    list.AddLine({x, at.y + high}, {x, at.y + high + 3}, ImGui::GetColorU32(ImGuiCol_Text));
    const float left = std::max(std::min(x - wide / 2, at.x + width - wide), at.x);
    if (left < free) continue;
    list.AddText({left, at.y + high + 3}, ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
    free = left + wide + lineHeight() / 3;
  }
  ImGui::Dummy({1, high + lineHeight() + 4});
  if (legend.unknown > 0) {
    legendRow(-2, {"no value", grouped(legend.unknown), kNoValue, LegendRow::Look::Shown}, false, width);
    if (!legend.whyUnknown.empty()) drawWrapped(dimText, legend.whyUnknown);
  }
  if (use == PanelUse::Picture) return {};
  float ends[2] = {static_cast<float>(legend.low), static_cast<float>(legend.high)};
  const auto speed = static_cast<float>(std::max(legend.high - legend.low, 1e-6) / 200);
  ImGui::SetNextItemWidth(width);
  if (!ImGui::DragFloat2("##ends", ends, speed, 0, 0, "%.4g")) return {};
  if (!std::isfinite(ends[0]) || !std::isfinite(ends[1]) || !(ends[0] < ends[1])) return {};
  return ScaleRange{ends[0], ends[1]};
}

PixelRect legendRect(const Legend& legend, const PixelRect& body, double lineHeight, int maxWidth) {
  if (!legend.scale && legend.entries.empty()) return {};
  constexpr std::size_t kScaleRows = 6;  // bar, numbers, count of unknown values, and texts that are wrapped
  const std::size_t rows = legend.scale ? kScaleRows : legend.entries.size();
  // A row is as high as legendRow() and the spacing between rows; the title and the edges take two more.
  const int high = static_cast<int>(std::ceil((static_cast<double>(rows) + 2) * (1.3 * lineHeight + 2)));
  const int right = body.left + body.width;
  if (right + sideWidth(lineHeight) > maxWidth) return {body.left, body.top + body.height, body.width, high};
  return {right, body.top, sideWidth(lineHeight), std::max(body.height, high)};
}

void legendPanel(const Legend& legend, const PixelRect& rect) {
  panelAt("##side", rect, PanelUse::Picture, [&] {
    section(legend.scale ? scaleTitle(legend) : legend.title, PanelUse::Picture, [&] {
      if (legend.scale) {
        scaleBar(legend, PanelUse::Picture);
      } else {
        legendRows(legend, {}, false, PanelUse::Picture);
      }
    });
  });
}

void textAt(double x, double y, double width, const std::string& text) {
  ImGui::SetCursorScreenPos({static_cast<float>(x), static_cast<float>(y)});
  textLine(fitted(text, static_cast<float>(width)));
}

void heading(const std::string& text, const Rgb& color) {
  swatch(ImGui::GetCursorScreenPos(), color, true);
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + lineHeight() * 1.25F);
  textLine(text);
}

void valueRows(const char* id, const NamedValues& rows, const std::string& alarm) {
  if (rows.empty() || !ImGui::BeginTable(id, 2, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoSavedSettings))
    return;
  ImGui::TableSetupColumn("name");
  ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthStretch);
  for (const auto& [name, value] : rows) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    dimText(name);
    ImGui::TableNextColumn();
    const bool warns = !alarm.empty() && name == alarm;
    if (warns) ImGui::PushStyleColor(ImGuiCol_Text, packed(kAlarm));
    drawWrapped(textLine, value);
    if (warns) ImGui::PopStyleColor();
  }
  ImGui::EndTable();
}

void tooltip(const std::string& title, const Rgb& color, const NamedValues& rows, const std::string& alarm) {
  ImGui::BeginTooltip();
  heading(title, color);
  for (const auto& [name, value] : rows) {
    dimText(name);
    ImGui::SameLine(lineHeight() * 7);
    if (name == alarm) ImGui::PushStyleColor(ImGuiCol_Text, packed(kAlarm));
    textLine(value);
    if (name == alarm) ImGui::PopStyleColor();
  }
  ImGui::EndTooltip();
}

bool imageAt(ImageId image, const PixelRect& rect, const std::optional<std::pair<double, double>>& mark) {
  const ImVec2 corner = ImGui::GetWindowPos();
  const ImVec2 size = ImGui::GetWindowSize();
  ImGui::PushClipRect(corner, {corner.x + size.x, corner.y + size.y}, false);  // clips the image at the panel's edge
  ImGui::SetCursorScreenPos({static_cast<float>(rect.left), static_cast<float>(rect.top)});
  ImGui::Image(textureOf(image), {static_cast<float>(rect.width), static_cast<float>(rect.height)});
  const bool over = ImGui::IsItemHovered();
  if (mark) {
    const ImVec2 at{static_cast<float>(mark->first), static_cast<float>(mark->second)};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddCircle(at, lineHeight() * 0.4F, packed({0, 0, 0}), 0, lineHeight() * 0.25F);
    list.AddCircle(at, lineHeight() * 0.4F, packed({255, 255, 255}), 0, lineHeight() * 0.12F);
  }
  ImGui::PopClipRect();
  return over;
}

bool messages(const PixelRect& within, const std::vector<std::string>& problems,
              const std::vector<std::string>& notices) {
  const float margin = lineHeight() * 0.5F;
  const float wide = std::min(static_cast<float>(within.width) - 2 * margin, lineHeight() * 36);
  float bottom = static_cast<float>(within.top + within.height) - margin;
  if (wide < lineHeight()) return false;
  bool closed = false;
  const auto box = [&](const char* name, const std::vector<std::string>& texts, bool warns) {
    constexpr std::size_t kMost = 6;
    if (texts.empty()) return;
    ImGui::SetNextWindowPos({static_cast<float>(within.left) + margin, bottom}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowSizeConstraints({1, 1}, {wide, static_cast<float>(within.height) * 0.6F});
    if (warns) ImGui::PushStyleColor(ImGuiCol_Border, packed(kAlarm));
    ImGui::Begin(name, nullptr, kMessage | (warns ? 0 : ImGuiWindowFlags_NoInputs));
    ImGui::PushTextWrapPos(wide - 2 * margin);
    for (std::size_t i = 0; i < std::min(texts.size(), kMost); ++i) textLine(texts[i]);
    if (texts.size() > kMost) textLine(fmt::format("+ {} more", texts.size() - kMost));
    ImGui::PopTextWrapPos();
    if (warns && ImGui::IsWindowHovered() && ImGui::IsMouseClicked(0)) closed = true;
    bottom -= ImGui::GetWindowHeight() + margin;
    ImGui::End();
    if (warns) ImGui::PopStyleColor();
  };
  box("##problems", problems, true);
  box("##notices", notices, false);
  return closed;
}

bool helpWindow(const NamedValues& keys) {
  const ImVec2 all = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({all.x / 2, all.y / 2}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::min(lineHeight() * 44, all.x), std::min(lineHeight() * 48, all.y * 0.9F)});
  ImGui::SetNextWindowFocus();
  bool open = true;
  if (ImGui::Begin("Keys", &open,
                   ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                       ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav))
    valueRows("keys", keys);
  ImGui::End();
  return open;
}

}  // namespace scanmill
