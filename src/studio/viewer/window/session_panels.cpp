// Draws menus and panels. Menus and buttons execute the same actions as keys.

#include <fmt/core.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>

#include "base/short_text.h"
#include "viewer/color_map.h"
#include "viewer/coloring.h"
#include "viewer/picture.h"
#include "viewer/window/picking.h"
#include "viewer/window/session.h"

namespace scanmill {

// Draws all panels once and executes what the user has clicked.
void ViewSession::runPanels() {
  panels_.imgui.frame([&] { drawPanels(); });
}

void ViewSession::drawPanels() {
  panels_.overStrip = false;
  drawLabels(panels_.labels);
  for (std::size_t v = 0; v < std::min(panels_.panes.size(), context_.redraw.views().size()); ++v) {
    drawMessage(context_.redraw.views()[v].rect, panels_.panes[v].message);
    if (panels_.panes.size() > 1)
      drawCaption(context_.redraw.views()[v].rect, panels_.panes[v].caption, panels_.panes[v].active);
  }
  if (context_.options.bare) return;
  context_.options.still ? titleRow(panels_.rects.title, panels_.title(), panels_.summary()) : drawMenus();
  const PanelUse use = panelUse();
  panelAt("##side", panels_.rects.side, use, [&] {
    if (!context_.options.still) drawColumns();
    drawLegends(true);
    if (pointer_.pinned) {
      section("Point", use, [&] {
        heading(pointer_.pinned->heading, pointer_.colorOf(*pointer_.pinned));
        valueRows("point", pointer_.pinned->rows, pointer_.pinned->alarm);
      });
    }
    if (!context_.options.still && !clouds_.list.empty()) {
      const bool known = !clouds_.scanOf(clouds_.list.front()).scan[kInstance].empty();
      if (known && ImGui::CollapsingHeader("Instances")) drawInstances();
    }
    drawLegends(false);
  });
  drawStrip();
  if (!context_.options.still) {
    drawFrameBar();
    std::vector<std::string> notices;
    for (const ViewNotice& notice : context_.notices) notices.push_back(notice.text);
    if (messages(panels_.rects.body, problems(), notices)) {  // the frame's own problems cannot be dismissed
      clouds_.colorProblem.clear();
      sceneView_.meshProblem.clear();
      clouds_.stripProblem.clear();
      clouds_.instanceProblem.clear();
      context_.changes.panels = true;
    }
    if (panels_.prompt) drawPrompt();
    if (panels_.help && !helpWindow(viewKeys())) panels_.help = false;
  }
  drawTooltip();
}

// True if what the command switches is on.
bool ViewSession::isOn(const KeyMeaning& meaning) const {
  using enum KeyAction;
  if (meaning.option != nullptr) return context_.options.*meaning.option;
  if (meaning.action == ToggleBoxes) return sceneView_.instanceBoxes;
  return (meaning.action == ToggleOverlay && clouds_.overlaid()) ||
         (meaning.action == ToggleSplit && context_.options.layout == ViewLayout::Split) ||
         (meaning.action == ToggleWorld && sceneView_.world) ||
         (meaning.action == InstanceAlone && !context_.filter.instances.empty());
}

void ViewSession::drawMenus() {
  if (!ImGui::BeginMainMenuBar()) return;
  std::string_view open;
  bool drawn = false;
  for (const ViewCommand& command : viewCommands()) {
    if (command.menu.empty()) continue;
    if (command.menu != open) {
      if (drawn) ImGui::EndMenu();
      open = command.menu;
      drawn = ImGui::BeginMenu(open.data());
    }
    if (!drawn) continue;
    const std::string lacks = context_.source->isScene() ? sceneLacks(command.meaning) : "";
    const bool on = isOn(command.meaning);
    if (ImGui::MenuItem(command.label.c_str(), keysText(command).c_str(), on, lacks.empty())) act(command.meaning);
  }
  if (drawn) ImGui::EndMenu();
  const std::string text = fmt::format("{}   {}", panels_.title(), panels_.summary());
  const float wide = ImGui::CalcTextSize(text.c_str()).x;
  const float left = static_cast<float>(context_.canvas.width()) - wide - ImGui::GetFontSize();
  ImGui::SameLine(std::max(left, ImGui::GetCursorPosX() + ImGui::GetFontSize()));
  ImGui::TextUnformatted(panels_.title().c_str());
  ImGui::SameLine();
  ImGui::TextDisabled("%s", panels_.summary().c_str());
  ImGui::EndMainMenuBar();
}

// Draws the menu of quantities that colours can show: those of colorsOf() that the scan has, or kMeshColorNames.
void ViewSession::drawColumns() {
  std::vector<ColorBy> all;
  std::string shown;
  if (context_.source->isScene()) {
    for (const std::string_view name : kMeshColorNames) all.emplace_back(std::string(name));
    shown = kMeshColorNames[static_cast<std::size_t>(sceneView_.meshColor)];
  } else if (!clouds_.list.empty() && !clouds_.overlaid()) {
    const std::size_t view = clouds_.activeView.value_or(0);
    const ShownCloud* const cloud = clouds_.inView(view);
    if (cloud == nullptr) return;
    const ViewScan& scan = context_.frame->scans[cloud->scan];
    for (const ColorBy& by : colorsOf(scan.scan)) {
      if (clouds_.hasColor(scan, by)) all.push_back(by);
    }
    shown = clouds_.colorOf(view).name();
  }
  if (all.empty()) return;
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (!ImGui::BeginCombo("##columns", ("colours: " + shown).c_str())) return;
  std::optional<ColorBy> chosen;
  for (const ColorBy& by : all) {
    if (ImGui::Selectable(by.name().c_str(), by.name() == shown)) chosen = by;
  }
  ImGui::EndCombo();
  if (chosen) chooseColor(*chosen);
}

// Draws the legends that are scales if `ofScales` is true; otherwise draws those that are lists.
void ViewSession::drawLegends(bool ofScales) {
  const bool choose = !context_.options.still && !clouds_.overlaid() && !clouds_.list.empty();
  const auto blocks = panels_.legends;  // a copy, since a click changes `legends`
  for (const LegendBlock& block : blocks) {
    const Legend& legend = block.legend;
    if (legend.scale != ofScales) continue;
    std::string name = legend.scale ? scaleTitle(legend) : legend.title;
    if (blocks.size() > 1 && context_.frame && context_.frame->scans.size() > 1) {
      name += ": " + panels_.panes[block.views.front()].caption;
    }
    section(name, panelUse(), [&] {
      if (legend.scale) {
        const auto range = scaleBar(legend, choose ? PanelUse::Interactive : PanelUse::Picture);
        if (!range) return;
        for (const std::size_t view : block.views) {
          clouds_.scales[view] = range;
          clouds_.recolor(view);
        }
        return;
      }
      std::vector<bool> hidden;
      for (const LegendEntry& entry : legend.entries) hidden.push_back(panels_.isHidden(entry));
      const bool clickable =
          std::ranges::any_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
      const LegendClick use = legendRows(legend, hidden, clickable, panelUse());
      if (use.all) act({KeyAction::ShowAllClasses});
      if (use.entry) pressLegend(legend.entries[*use.entry], panels_.imgui.shift() || panels_.imgui.clicks() == 2);
    });
  }
}

// Hides or shows the class or the scan of a legend's row; if `alone` is true, shows this class or scan and no other.
void ViewSession::pressLegend(const LegendEntry& entry, bool alone) {
  if (entry.id < 0) return;
  if (clouds_.overlaid()) {
    const auto chosen = static_cast<std::size_t>(entry.id);
    if (alone) {
      context_.filter.hiddenScans.clear();
      for (std::size_t s = 0; s < context_.frame->scans.size(); ++s) {
        if (s != chosen) context_.filter.hiddenScans.insert(context_.frame->scans[s].name);
      }
    } else if (context_.filter.hiddenScans.erase(context_.frame->scans[chosen].name) == 0) {
      context_.filter.hiddenScans.insert(context_.frame->scans[chosen].name);
    }
  } else if (const auto id = static_cast<std::uint16_t>(entry.id); alone) {
    context_.filter.classes.showOnly(id);
  } else {
    context_.filter.classes.toggle(id);
  }
  applyFilter();
}

void ViewSession::drawStrip() {
  if (!clouds_.strip || panels_.rects.strip.height < 1) return;
  const PixelRect rect = panels_.stripRect();
  std::optional<std::pair<double, double>> mark;
  const PickedElement* const picked = pointer_.shown();
  if (picked != nullptr && picked->scan == clouds_.list[clouds_.stripCloud].scan) {
    const auto [column, row] = clouds_.strip->place(picked->point);
    mark = std::pair(rect.left + (column + 0.5) * rect.width / clouds_.strip->image.width,
                     rect.top + (row + 0.5) * rect.height / clouds_.strip->image.height);
  }
  const std::string caption =
      clouds_.scanOf(clouds_.list[clouds_.stripCloud]).name + ": " + describeStrip(*clouds_.strip);
  bool pressed = false;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, ImGui::GetFontSize() * 0.2F});
  panelAt("##strip", panels_.rects.strip, PanelUse::Picture, [&] {
    ImGui::SetCursorPosX(ImGui::GetFontSize() * 0.5F);
    if (rect.top > panels_.rects.strip.top) ImGui::TextDisabled("%s", caption.c_str());
    panels_.overStrip = imageAt(kStripImage, rect, mark);
    pressed = panels_.overStrip && ImGui::IsMouseClicked(0);
  });
  ImGui::PopStyleVar();
  if (!pressed) return;
  if (auto picked = pointer_.pickStrip(rect, pointer_.x, pointer_.y)) {
    pointer_.lookAt(picked->position);
    pointer_.pinned = pointer_.withOtherScans(std::move(*picked));
  }
}

// Draws the button that plays frames, the slider that chooses one, and what is being loaded.
void ViewSession::drawFrameBar() {
  const std::size_t requested = playback_.requested();
  panelAt("##frames", panels_.rects.bar, PanelUse::Picture, [&] {
    const float lineHeight = ImGui::GetFontSize();
    const bool several = playback_.count() > 1;
    if (several) {
      if (ImGui::Button(playback_.playing() ? "Pause" : "Play", {lineHeight * 4, 0})) togglePlaying();
      ImGui::SameLine();
      const float width = ImGui::GetContentRegionAvail().x;
      ImGui::SetNextItemWidth(width < lineHeight * 30 ? width : width * 0.45F);
      const int last = static_cast<int>(playback_.count()) - 1;
      int at = static_cast<int>(requested);
      if (ImGui::SliderInt("##frame", &at, 0, last, "", ImGuiSliderFlags_AlwaysClamp) &&
          at != static_cast<int>(requested)) {
        playback_.stop();
        goTo(static_cast<std::size_t>(std::clamp(at, 0, last)), at > static_cast<int>(requested) ? 1 : -1);
      }
      ImGui::SameLine();
      ImGui::AlignTextToFramePadding();
      textLine(fmt::format("#{} of {}   {}", requested, playback_.count(), context_.source->keys()[requested]));
    }
    if (playback_.busy().empty()) return;
    if (several) ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    dimText("loading " + playback_.busy());
  });
}

void ViewSession::drawPrompt() {
  constexpr std::size_t kMost = 200;
  const float lineHeight = ImGui::GetFontSize();
  const float middle = static_cast<float>(panels_.rects.body.left) + static_cast<float>(panels_.rects.body.width) / 2;
  const auto wide = static_cast<float>(panels_.rects.body.width);
  const auto high = static_cast<float>(panels_.rects.body.height);
  ImGui::SetNextWindowPos({middle, static_cast<float>(panels_.rects.body.top) + lineHeight}, ImGuiCond_Always,
                          {0.5F, 0});
  ImGui::SetNextWindowSize({std::min(lineHeight * 28, wide), std::min(lineHeight * 22, high - 2 * lineHeight)});
  ImGui::Begin("Go to sample", nullptr,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings);
  ImGui::TextDisabled("a key, a part of one, or #index from 0");
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::IsAnyItemActive()) ImGui::SetKeyboardFocusHere();
  const bool entered = ImGui::InputText("##key", &*panels_.prompt, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::Separator();
  std::size_t found = 0;
  std::optional<std::string> chosen;
  const bool byIndex = panels_.prompt->starts_with('#');
  for (std::size_t i = 0; i < context_.source->keys().size(); ++i) {
    const std::string& key = context_.source->keys()[i];
    const bool fits =
        byIndex ? fmt::format("#{}", i).starts_with(*panels_.prompt) : key.find(*panels_.prompt) != std::string::npos;
    if (!fits) continue;
    if (found++ < kMost && ImGui::Selectable(key.c_str())) chosen = key;
  }
  if (found > kMost) ImGui::TextDisabled("and %s more", grouped(found - kMost).c_str());
  if (found == 0) ImGui::TextDisabled("no key holds this");
  ImGui::End();
  if (entered) chosen = *panels_.prompt;
  if (ImGui::IsKeyPressed(ImGuiKey_Escape) || (entered && panels_.prompt->empty())) return panels_.prompt.reset();
  if (!chosen) return;
  try {
    goTo(findFrame(*context_.source, *chosen), 1);
    panels_.prompt.reset();
  } catch (const InputError& e) {
    context_.notify(e.what());
  }
}

// Draws the tooltip beside the pointer.
void ViewSession::drawTooltip() {
  const bool isPinned = pointer_.pinned && pointer_.hover && pointer_.pinned->scan == pointer_.hover->scan &&
                        pointer_.pinned->point == pointer_.hover->point;
  if (pointer_.hover && !isPinned && !pointer_.measuring && !panels_.help)
    tooltip(pointer_.hover->heading, pointer_.colorOf(*pointer_.hover), pointer_.hover->brief, pointer_.hover->alarm);
}

void ViewSession::drawInstances() {
  constexpr int kRows = 14;
  constexpr ImGuiTableFlags kTable = ImGuiTableFlags_Sortable | ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                                     ImGuiTableFlags_NoSavedSettings | ImGuiTableFlags_SizingStretchProp;
  const float high = ImGui::GetTextLineHeightWithSpacing() * kRows;
  if (!ImGui::BeginTable("instances", 4, kTable, {0, high})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  // A first click on the heading of the columns "points" and "box (m)" sorts in descending order.
  for (const auto& [name, share] : {std::pair("class", 0.28F), {"id", 0.12F}, {"points", 0.19F}, {"box (m)", 0.41F}}) {
    const bool large = name[0] == 'p' || name[0] == 'b';
    ImGui::TableSetupColumn(
        name, ImGuiTableColumnFlags_WidthStretch | (large ? ImGuiTableColumnFlags_PreferSortDescending : 0), share);
  }
  ImGui::TableHeadersRow();
  std::vector<const InstanceSummary*> rows;
  for (const InstanceSummary& instance : sceneView_.instances()) rows.push_back(&instance);
  if (const ImGuiTableSortSpecs* const sort = ImGui::TableGetSortSpecs(); sort != nullptr && sort->SpecsCount > 0) {
    const auto value = [&](const InstanceSummary* instance) {
      const std::array<double, 4> columns{static_cast<double>(classOf(*instance)), static_cast<double>(instance->id),
                                          static_cast<double>(instance->points.size()), instance->size.x};
      return columns.at(static_cast<std::size_t>(sort->Specs->ColumnIndex));
    };
    const bool down = sort->Specs->SortDirection == ImGuiSortDirection_Descending;
    std::ranges::stable_sort(
        rows, [&](const auto* a, const auto* b) { return down ? value(a) > value(b) : value(a) < value(b); });
  }
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(rows.size()));
  const InstanceSummary* chosen = nullptr;
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const InstanceSummary& instance = *rows[static_cast<std::size_t>(i)];
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::PushID(static_cast<int>(instance.id));
      const std::string name = className(context_.source->ontology(), classOf(instance)) + "##row";
      const bool marked = pointer_.pinned && pointer_.instanceOf(*pointer_.pinned) == instance.id;
      if (ImGui::Selectable(name.c_str(), marked, ImGuiSelectableFlags_SpanAllColumns)) chosen = &instance;
      ImGui::PopID();
      ImGui::TableNextColumn();
      ImGui::Text("%u", instance.id);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(grouped(instance.points.size()).c_str());
      ImGui::TableNextColumn();
      ImGui::Text("%.1f %.1f %.1f", instance.size.x, instance.size.y, instance.size.z);
    }
  }
  ImGui::EndTable();
  if (chosen == nullptr) return;
  pointer_.pinned = pointer_.withOtherScans(pointer_.pickedPoint(0, chosen->points[chosen->points.size() / 2]));
  pointer_.lookAt(chosen->levelFromBox.translation);
  context_.changes.panels = true;
}

}  // namespace scanmill
