#include "viewer/panels/widgets.h"

#include <fmt/core.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "base/short_text.h"
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

// Returns the height of a line of text (pixels). Sizes in this file are multiples of this height or, for edges and
// gaps, 1 to 4 pixels; all are chosen by eye.
float lineHeight() {
  return ImGui::GetFontSize();
}

ImVec2 sizeOf(const std::string& text) {
  return ImGui::CalcTextSize(text.data(), text.data() + text.size());
}

ImRect rectOf(const PixelRect& rect) {
  const auto left = static_cast<float>(rect.left), top = static_cast<float>(rect.top);
  return {left, top, left + static_cast<float>(rect.width), top + static_cast<float>(rect.height)};
}

// Adds a text to a list of drawings. `position`: upper left corner of the text (pixels of the canvas).
void addText(ImDrawList& list, const ImVec2& position, ImU32 color, const std::string& text) {
  list.AddText(position, color, text.data(), text.data() + text.size());
}

// Adds a white ring with a black edge, which is visible on any background. `radius`: in heights of a line.
void addRing(ImDrawList& list, const ImVec2& center, float radius) {
  list.AddCircle(center, lineHeight() * radius, packed({0, 0, 0}), 0, lineHeight() * 0.25F);
  list.AddCircle(center, lineHeight() * radius, packed({255, 255, 255}), 0, lineHeight() * 0.12F);
}

void drawWrapped(void (*draw)(const std::string&), const std::string& text) {
  ImGui::PushTextWrapPos(0);
  draw(text);
  ImGui::PopTextWrapPos();
}

// Returns the text; if it is wider than `width` pixels, only as much of its beginning as fits, followed by "...".
std::string fitted(const std::string& text, float width) {
  if (sizeOf(text).x <= width) return text;
  const float dotsWidth = sizeOf("...").x;
  std::size_t length = text.size();  // number of bytes that are kept
  // True if the byte continues a character of UTF-8.
  const auto isInCharacter = [&](std::size_t byte) { return (static_cast<unsigned char>(text[byte]) & 0xC0) == 0x80; };
  // First halve the text repeatedly, since it may be very long.
  while (length > 64 && sizeOf(text.substr(0, length / 2)).x > width) length /= 2;
  while (length > 0 &&
         (sizeOf(text.substr(0, length)).x + dotsWidth > width || (length < text.size() && isInCharacter(length)))) {
    --length;
  }
  return text.substr(0, length) + "...";
}

constexpr float kTextIndent = 1.25F;  // distance from a swatch's left end to its text, in heights of a line

// Draws a small square with the colour of a row of text; only an edge unless `filled`. `rowCorner`: upper left corner.
void drawSwatch(const ImVec2& rowCorner, const Rgb& color, bool filled) {
  const float side = std::floor(lineHeight() * 0.75F);
  const ImVec2 corner{std::floor(rowCorner.x), std::floor(rowCorner.y + (lineHeight() - side) / 2)};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, {corner.x + side, corner.y + side}, packed(filled ? color : mix(color, kNoValue, 0.4)));
  if (filled) return;
  const float edge = std::max(std::floor(side / 6), 1.0F);
  list.AddRectFilled({corner.x + edge, corner.y + edge}, {corner.x + side - edge, corner.y + side - edge},
                     ImGui::GetColorU32(ImGuiCol_WindowBg, 1000));
}

struct LegendRow {
  std::string name;
  std::string count;  // number of points as text; empty: not shown
  Rgb color{};
  enum class Look {
    Shown,
    Absent,  // shown, but no point of the frame has the entry's value
    Partly,  // the row "all" if some entries are hidden
    Hidden,
  } look = Look::Shown;
};

// Draws a row of a legend: swatch, name and, at the right end, the count. `id`: unique in the legend. Returns true if
// the user has clicked the row.
bool drawLegendRow(int id, const LegendRow& row, bool clickable) {
  using Look = LegendRow::Look;
  const float width = ImGui::GetContentRegionAvail().x;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 end{corner.x + width, corner.y + lineHeight() + 2};  // lower right corner
  ImDrawList& list = *ImGui::GetWindowDrawList();
  bool pressed = false;
  ImGui::PushID(id);
  if (clickable) {
    ImGui::InvisibleButton("row", {std::max(width, 1.0F), lineHeight() + 2});
    pressed = ImGui::IsItemActivated();
    if (ImGui::IsItemHovered()) {
      list.AddRectFilled({corner.x - 2, corner.y}, end, ImGui::GetColorU32(ImGuiCol_HeaderHovered), 3);
    }
  } else {
    ImGui::Dummy({std::max(width, 1.0F), lineHeight() + 2});
  }
  ImGui::PopID();
  const float top = corner.y + 1;  // upper edge of the text
  drawSwatch({corner.x, top}, row.color, row.look == Look::Shown || row.look == Look::Absent);
  const float countWidth = row.count.empty() ? 0 : sizeOf(row.count).x + lineHeight() * 0.5F;
  const float nameLeft = corner.x + lineHeight() * kTextIndent;
  const std::string name = fitted(row.name, width - lineHeight() * kTextIndent - countWidth);
  if (name != row.name && ImGui::IsMouseHoveringRect(corner, end)) ImGui::SetTooltip("%s", row.name.c_str());
  const ImU32 color = ImGui::GetColorU32(row.look == Look::Shown ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  addText(list, {nameLeft, top}, color, name);
  if (row.look == Look::Hidden) {  // the name is struck through
    const float middle = top + lineHeight() * 0.55F;
    list.AddLine({nameLeft, middle}, {nameLeft + sizeOf(name).x, middle}, color);
  }
  if (!row.count.empty()) {
    addText(list, {end.x - sizeOf(row.count).x, top}, ImGui::GetColorU32(ImGuiCol_TextDisabled), row.count);
  }
  return pressed;
}

}  // namespace

void panelAt(const char* name, const PixelRect& rect, PanelUse use, const std::function<void()>& body) {
  if (rect.width < 1 || rect.height < 1) return;
  ImGui::SetNextWindowPos(rectOf(rect).Min);
  ImGui::SetNextWindowSize(rectOf(rect).GetSize());
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  const ImGuiWindowFlags scrolling =
      use == PanelUse::Interactive ? 0 : ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse;
  if (ImGui::Begin(name, nullptr, kFixed | scrolling)) body();
  ImGui::End();
  ImGui::PopStyleVar(3);
}

void titleRow(const PixelRect& rect, const std::string& left, const std::string& right) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding,
                      {lineHeight() * 0.6F, std::max(static_cast<float>(rect.height) - lineHeight(), 0.0F) / 2});
  panelAt("##title", rect, PanelUse::Picture, [&] {
    const float width = ImGui::GetContentRegionAvail().x;
    const std::string leftText = fitted(left, width);
    textLine(leftText);
    const float rightWidth = sizeOf(right).x;
    if (rightWidth + sizeOf(leftText).x + lineHeight() > width) return;
    ImGui::SameLine(ImGui::GetCursorPosX() + width - rightWidth);
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
  const float margin = lineHeight() * 0.5F;
  std::vector<ImRect> drawn;  // areas of the texts so far
  for (const PanelLabel& label : labels) {
    const ImVec2 center{static_cast<float>(label.x), static_cast<float>(label.y)};
    const ImRect view = rectOf(label.within);
    if (label.mark) addRing(list, center, 0.45F);
    if (label.text.empty()) continue;
    const std::string text = fitted(label.text, view.GetWidth() - 2 * margin);
    const ImVec2 size = sizeOf(text);
    // If the text would extend beyond the view, draw it on the other side of the mark.
    float x = center.x + 2 * margin;
    if (x + size.x + margin > view.Max.x) x = std::max(center.x - 2 * margin - size.x, view.Min.x + margin);
    float y = center.y - margin - size.y;
    if (y < view.Min.y + margin) y = center.y + 2 * margin;
    const ImRect area(x - 3, y - 1, x + size.x + 3, y + size.y + 1);
    const auto overlaps = [&](const ImRect& other) { return area.Overlaps(other); };
    if (label.optional && std::ranges::any_of(drawn, overlaps)) continue;
    drawn.push_back(area);
    list.AddRectFilled(area.Min, area.Max, packed(kBackground, 200), 3);
    addText(list, {std::floor(x), std::floor(y)}, packed({255, 255, 255}), text);
  }
}

void drawCaption(const PixelRect& view, const std::string& text, bool active) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImRect area = rectOf(view);
  const float inset = lineHeight() * 0.5F;
  if (active) {
    list.AddRect(area.Min, area.Max, ImGui::GetColorU32(ImGuiCol_CheckMark), 0, 0, std::max(lineHeight() / 8, 2.0F));
  }
  if (text.empty() || area.GetHeight() < 3 * lineHeight()) return;
  const std::string caption = fitted(text, area.GetWidth() - 4 * inset);
  const ImVec2 corner{area.Min.x + inset, area.Min.y + inset};
  const ImVec2 size = sizeOf(caption);
  list.AddRectFilled(corner, {corner.x + size.x + 2 * inset, corner.y + size.y + inset},
                     ImGui::GetColorU32(ImGuiCol_WindowBg), 4);
  addText(list, {corner.x + inset, corner.y + inset / 2}, ImGui::GetColorU32(ImGuiCol_Text), caption);
}

void drawMessage(const PixelRect& view, const std::string& text) {
  constexpr float kLarge = 1.5F;  // size of the letters in heights of a line
  const float size = lineHeight() * kLarge;
  const ImRect area = rectOf(view);
  const float maxWidth = std::min(area.GetWidth() - 4 * size, 40 * size);
  if (text.empty() || maxWidth < size) return;
  const char* const textEnd = text.data() + text.size();
  const ImVec2 extent = ImGui::GetFont()->CalcTextSizeA(size, maxWidth, maxWidth, text.data(), textEnd);
  const ImVec2 corner{std::floor(area.Min.x + (area.GetWidth() - extent.x) / 2),
                      std::floor(area.Min.y + (area.GetHeight() - extent.y) / 2)};
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled({corner.x - size, corner.y - size / 2},
                     {corner.x + extent.x + size, corner.y + extent.y + size / 2},
                     ImGui::GetColorU32(ImGuiCol_WindowBg), size / 3);
  list.AddText(ImGui::GetFont(), size, corner, ImGui::GetColorU32(ImGuiCol_Text), text.data(), textEnd, maxWidth);
}

LegendClick drawLegendRows(const Legend& legend, const std::vector<bool>& hidden, bool clickable, PanelUse use) {
  using Look = LegendRow::Look;
  LegendClick click;
  const std::size_t entries = legend.entries.size();
  const auto isHidden = [&](std::size_t i) { return i < hidden.size() && hidden[i]; };
  std::uint64_t points = 0;  // number of points of all entries
  for (const LegendEntry& entry : legend.entries) points += entry.points;
  const auto isAbsent = [&](const LegendEntry& entry) { return points > 0 && entry.points == 0; };
  const auto countText = [&](std::uint64_t count) { return points > 0 ? grouped(count) : std::string(); };
  if (clickable && use == PanelUse::Interactive && entries > 1) {
    const auto hiddenEntries = static_cast<std::size_t>(std::ranges::count(hidden, true));
    const Look look = hiddenEntries == 0 ? Look::Shown : hiddenEntries < entries ? Look::Partly : Look::Hidden;
    const ImVec4 color = ImGui::GetStyleColorVec4(ImGuiCol_Text);
    const auto byte = [](float channel) { return static_cast<std::uint8_t>(std::lround(channel * 255)); };
    const LegendRow row{"all", countText(points), {byte(color.x), byte(color.y), byte(color.z)}, look};
    click.allEntries = drawLegendRow(-1, row, true);
  }
  // A picture shows only the entries that have points, and only as many as fit into the panel.
  std::size_t undrawn = entries, lines = entries;
  if (use == PanelUse::Picture) {
    const float rowHeight = lineHeight() + 2 + ImGui::GetStyle().ItemSpacing.y;
    undrawn -= static_cast<std::size_t>(std::ranges::count_if(legend.entries, isAbsent));
    lines = static_cast<std::size_t>(std::max(ImGui::GetContentRegionAvail().y / rowHeight, 0.0F));
  }
  if (lines < undrawn && lines > 0) --lines;  // one line is needed for the number of omitted entries
  for (std::size_t i = 0; i < entries && lines > 0; ++i) {
    const LegendEntry& entry = legend.entries[i];
    if (use == PanelUse::Picture && isAbsent(entry)) continue;
    --lines;
    --undrawn;
    const Look look = isHidden(i) ? Look::Hidden : isAbsent(entry) ? Look::Absent : Look::Shown;
    const LegendRow row{entry.name, countText(entry.points), entry.color, look};
    if (drawLegendRow(static_cast<int>(i), row, clickable)) click.entry = i;
  }
  if (undrawn > 0) dimText(fmt::format("+ {} more", undrawn));
  return click;
}

std::optional<ScaleRange> drawScale(const Legend& legend, PanelUse use) {
  constexpr int kSteps = 64;  // rectangles of which the bar consists
  constexpr float kTick = 3;  // length of a tick below the bar (pixels)
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const float barHeight = std::floor(lineHeight() * 0.9F), barBottom = corner.y + barHeight;
  const ImU32 textColor = ImGui::GetColorU32(ImGuiCol_Text);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  for (int i = 0; i < kSteps; ++i) {
    const ImU32 left = packed(viridis(static_cast<double>(i) / kSteps));
    const ImU32 right = packed(viridis(static_cast<double>(i + 1) / kSteps));
    list.AddRectFilledMultiColor({corner.x + width * static_cast<float>(i) / kSteps, corner.y},
                                 {corner.x + width * static_cast<float>(i + 1) / kSteps, barBottom}, left, right, right,
                                 left);
  }
  float freeLeft = corner.x;  // no number has been drawn to the right of this x
  for (const auto& [position, text] : scaleTicks(legend)) {
    const float x = corner.x + width * static_cast<float>(position);
    list.AddLine({x, barBottom}, {x, barBottom + kTick}, textColor);
    const float textWidth = sizeOf(text).x;
    const float left = std::max(std::min(x - textWidth / 2, corner.x + width - textWidth), corner.x);
    if (left < freeLeft) continue;
    addText(list, {left, barBottom + kTick}, textColor, text);
    freeLeft = left + textWidth + lineHeight() / 3;
  }
  ImGui::Dummy({1, barHeight + lineHeight() + 4});
  if (legend.unknown > 0) {
    drawLegendRow(-2, {"no value", grouped(legend.unknown), kNoValue}, false);
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
  constexpr std::size_t kScaleRows = 6;  // rows for the bar, its numbers, the count of unknown values and wrapped texts
  const std::size_t rows = legend.scale ? kScaleRows : legend.entries.size();
  // The height of a row includes the space to the next row. The title and the edges need two more rows.
  const int height = static_cast<int>(std::ceil((static_cast<double>(rows) + 2) * (1.3 * lineHeight + 2)));
  const int right = body.left + body.width;
  if (right + sideWidth(lineHeight) > maxWidth) return {body.left, body.top + body.height, body.width, height};
  return {right, body.top, sideWidth(lineHeight), std::max(body.height, height)};
}

Image drawWithLegend(const LegendPicture& picture, const Legend& legend, const std::function<void()>& drawBody) {
  PixelRect body = picture.body;
  const PixelRect side = legendRect(legend, body, picture.lineHeight, picture.maxWidth);
  if (side.left > 0) body.height = side.height;
  const PixelRect top{0, 0, std::max(body.width, side.left + side.width), body.top};
  const int height = std::max(body.top + body.height, side.top + side.height);
  const std::unique_ptr<Canvas> canvas = openOffscreen(top.width, height);
  ImGuiLayer imgui(*canvas, picture.lineHeight);
  for (std::size_t i = 0; i < picture.images.size(); ++i) {
    setImage(*canvas, static_cast<ImageId>(i), *picture.images[i]);
  }
  for (int i = 0; i < 2; ++i) {  // sizes that depend on contents are known in the second frame
    imgui.frame([&] {
      titleRow(top, picture.title, picture.details);
      panelAt("##body", body, PanelUse::Picture, drawBody);
      panelAt("##side", side, PanelUse::Picture, [&] {
        section(legend.scale ? scaleTitle(legend) : legend.title, PanelUse::Picture, [&] {
          legend.scale ? void(drawScale(legend, PanelUse::Picture))
                       : void(drawLegendRows(legend, {}, false, PanelUse::Picture));
        });
      });
    });
  }
  canvas->render();
  return canvas->read();
}

void textAt(double x, double y, double width, const std::string& text) {
  ImGui::SetCursorScreenPos({static_cast<float>(x), static_cast<float>(y)});
  textLine(fitted(text, static_cast<float>(width)));
}

void heading(const std::string& text, const Rgb& color) {
  drawSwatch(ImGui::GetCursorScreenPos(), color, true);
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + lineHeight() * kTextIndent);
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
    const bool isAlarm = !alarm.empty() && name == alarm;
    if (isAlarm) ImGui::PushStyleColor(ImGuiCol_Text, packed(kAlarm));
    drawWrapped(textLine, value);
    if (isAlarm) ImGui::PopStyleColor();
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
  ImGui::SetCursorScreenPos(rectOf(rect).Min);
  ImGui::Image(textureOf(image), rectOf(rect).GetSize());
  const bool isHovered = ImGui::IsItemHovered();
  if (mark) {
    addRing(*ImGui::GetWindowDrawList(), {static_cast<float>(mark->first), static_cast<float>(mark->second)}, 0.4F);
  }
  ImGui::PopClipRect();
  return isHovered;
}

bool drawMessages(const PixelRect& within, const std::vector<std::string>& problems,
                  const std::vector<std::string>& notices) {
  const float margin = lineHeight() * 0.5F;
  const ImRect area = rectOf(within);
  const float maxWidth = std::min(area.GetWidth() - 2 * margin, lineHeight() * 36);
  float bottom = area.Max.y - margin;  // y of the lower edge of the next box
  if (maxWidth < lineHeight()) return false;
  // Draws a box of texts above `bottom`, and moves `bottom` up. Returns true if a box of problems was clicked.
  const auto drawBox = [&](const char* name, const std::vector<std::string>& texts, bool areProblems) {
    constexpr std::size_t kMost = 6;
    if (texts.empty()) return false;
    ImGui::SetNextWindowPos({area.Min.x + margin, bottom}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowSizeConstraints({1, 1}, {maxWidth, area.GetHeight() * 0.6F});
    if (areProblems) ImGui::PushStyleColor(ImGuiCol_Border, packed(kAlarm));
    ImGui::Begin(name, nullptr, kMessage | (areProblems ? 0 : ImGuiWindowFlags_NoInputs));
    ImGui::PushTextWrapPos(maxWidth - 2 * margin);
    for (std::size_t i = 0; i < std::min(texts.size(), kMost); ++i) textLine(texts[i]);
    if (texts.size() > kMost) textLine(fmt::format("+ {} more", texts.size() - kMost));
    ImGui::PopTextWrapPos();
    const bool clicked = areProblems && ImGui::IsWindowHovered() && ImGui::IsMouseClicked(0);
    bottom -= ImGui::GetWindowHeight() + margin;
    ImGui::End();
    if (areProblems) ImGui::PopStyleColor();
    return clicked;
  };
  const bool dismissed = drawBox("##problems", problems, true);
  drawBox("##notices", notices, false);
  return dismissed;
}

bool helpWindow(const NamedValues& keys) {
  const ImVec2 canvas = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({canvas.x / 2, canvas.y / 2}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::min(lineHeight() * 44, canvas.x), std::min(lineHeight() * 48, canvas.y * 0.9F)});
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
