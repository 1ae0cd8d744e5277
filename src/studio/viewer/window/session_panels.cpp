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
#include "viewer/window/picked_rows.h"
#include "viewer/window/session_state.h"

namespace scanmill {

// Draws all panels once and executes what the user has clicked.
void ViewSession::State::runPanels() {
  panels.toolkit.suit(context.options.background);
  panels.toolkit.frame([&] { drawPanels(); });
}

void ViewSession::State::drawPanels() {
  panels.overStrip = false;
  drawLabels(panels.labels,
             {0, panels.rooms.body.top, context.canvas.width(), context.canvas.height() - panels.rooms.body.top});
  for (std::size_t v = 0; v < std::min(panels.panes.size(), context.drawing.views().size()); ++v) {
    drawMessage(context.drawing.views()[v].rect, panels.panes[v].message);
    if (panels.panes.size() > 1)
      drawCaption(context.drawing.views()[v].rect, panels.panes[v].caption, panels.panes[v].active);
  }
  if (context.options.bare) return;
  context.options.still ? titleRow(panels.rooms.title, panels.title(), panels.summary()) : drawMenus();
  panelAt("##side", panels.rooms.side, !context.options.still, [&] {
    if (!context.options.still) drawColumns();
    drawLegends(true);
    if (pointer.pinned) {
      section("Point", context.options.still, [&] {
        heading(pointer.pinned->heading, pointer.colorOf(*pointer.pinned));
        valueRows("point", pointer.pinned->rows, pointer.pinned->alarm);
      });
    }
    if (!context.options.still && !clouds.list.empty()) {
      const bool known = !context.frame->scans[clouds.list.front().scan].scan[kInstance].empty();
      if (known) folded("Instances", [&] { drawInstances(); });
      folded("Scans", [&] { drawSources(); });
    }
    drawLegends(false);
  });
  drawStrip();
  if (!context.options.still) {
    drawFrameBar();
    std::vector<std::string> said;
    for (const ViewNotice& notice : context.notices) said.push_back(notice.text);
    if (messages(panels.rooms.body, problems(), said)) {  // the frame's own problems cannot be dismissed
      clouds.colorProblem.clear();
      scenery.meshProblem.clear();
      clouds.stripProblem.clear();
      clouds.instanceProblem.clear();
      context.changes.panels = true;
    }
    if (panels.prompt) drawPrompt();
    if (panels.help && !helpWindow(viewKeys())) panels.help = false;
  }
  drawTips();
}

// True if the option that the action switches is on.
bool ViewSession::State::isOn(KeyAction action) {
  if (const bool* const option = switchOf(action).first) return *option;
  return (action == KeyAction::ToggleMesh && scenery.meshOn()) ||
         (action == KeyAction::ToggleRangeImage && context.options.rangeImage) ||
         (action == KeyAction::ToggleOverlay && clouds.overlaid()) ||
         (action == KeyAction::ToggleSplit && context.options.layout == ViewLayout::Split) ||
         (action == KeyAction::ToggleWorld && scenery.world) ||
         (action == KeyAction::InstanceAlone && !context.filter.instances.empty());
}

void ViewSession::State::drawMenus() {
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
    const std::string lacks = context.source->isScene() ? sceneLacks(command.meaning) : "";
    const bool on = isOn(command.meaning.action);
    if (ImGui::MenuItem(command.label.c_str(), keysText(command).c_str(), on, lacks.empty())) act(command.meaning);
  }
  if (drawn) ImGui::EndMenu();
  const std::string text = fmt::format("{}   {}", panels.title(), panels.summary());
  const float wide = ImGui::CalcTextSize(text.c_str()).x;
  const float left = static_cast<float>(context.canvas.width()) - wide - ImGui::GetFontSize();
  ImGui::SameLine(std::max(left, ImGui::GetCursorPosX() + ImGui::GetFontSize()));
  ImGui::TextUnformatted(panels.title().c_str());
  ImGui::SameLine();
  ImGui::TextDisabled("%s", panels.summary().c_str());
  ImGui::EndMainMenuBar();
}

// Draws the menu of quantities that colours can show: those of colorsOf() that the scan has, or kMeshColorNames.
void ViewSession::State::drawColumns() {
  std::vector<ColorBy> all;
  std::string shown;
  if (context.source->isScene()) {
    for (const std::string_view name : kMeshColorNames) all.emplace_back(std::string(name));
    shown = kMeshColorNames[static_cast<std::size_t>(scenery.meshColor)];
  } else if (!clouds.list.empty() && !clouds.overlaid()) {
    const std::size_t view = clouds.activeView.value_or(0);
    const ShownCloud* const cloud = clouds.inView(view);
    if (cloud == nullptr) return;
    const ViewScan& scan = context.frame->scans[cloud->scan];
    for (const ColorBy& by : colorsOf(scan.scan)) {
      if (clouds.hasColor(scan, by)) all.push_back(by);
    }
    shown = clouds.colorOf(view).name();
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
void ViewSession::State::drawLegends(bool ofScales) {
  const bool choose = !context.options.still && !clouds.overlaid() && !clouds.list.empty();
  const auto blocks = panels.legends;  // a copy, since a click changes `legends`
  for (const LegendBlock& block : blocks) {
    const Legend& legend = block.legend;
    if (legend.scale != ofScales) continue;
    std::string name = legend.scale ? scaleTitle(legend) : legend.title;
    if (blocks.size() > 1 && context.frame && context.frame->scans.size() > 1) {
      name += ": " + panels.panes[block.views.front()].caption;
    }
    section(name, context.options.still, [&] {
      if (legend.scale) {
        const auto range = scaleBar(legend, !choose);
        if (!range) return;
        for (const std::size_t view : block.views) {
          clouds.scales[view] = range;
          clouds.recolor(view);
        }
        return;
      }
      std::vector<bool> hidden;
      for (const LegendEntry& entry : legend.entries) hidden.push_back(panels.isHidden(entry));
      const bool clickable =
          std::ranges::any_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
      const LegendUse use = legendRows(legend, hidden, clickable, context.options.still);
      if (use.all) act({KeyAction::ShowAllClasses});
      if (use.entry) pressLegend(legend.entries[*use.entry], panels.toolkit.shift() || panels.toolkit.clicks() == 2);
    });
  }
}

// Hides or shows the class or the scan of a legend's row; if `alone` is true, shows this class or scan and no other.
void ViewSession::State::pressLegend(const LegendEntry& entry, bool alone) {
  if (entry.id < 0) return;
  if (clouds.overlaid()) {
    const auto chosen = static_cast<std::size_t>(entry.id);
    if (alone) {
      context.filter.hiddenScans.clear();
      for (std::size_t s = 0; s < context.frame->scans.size(); ++s) {
        if (s != chosen) context.filter.hiddenScans.insert(context.frame->scans[s].name);
      }
    } else if (context.filter.hiddenScans.erase(context.frame->scans[chosen].name) == 0) {
      context.filter.hiddenScans.insert(context.frame->scans[chosen].name);
    }
  } else if (const auto id = static_cast<std::uint16_t>(entry.id); alone) {
    context.filter.classes.showOnly(id);
  } else {
    context.filter.classes.toggle(id);
  }
  applyFilter();
}

void ViewSession::State::drawStrip() {
  if (!clouds.strip || panels.rooms.strip.height < 1) return;
  const PixelRect rect = panels.stripRect();
  std::optional<std::pair<double, double>> mark;
  const PickedThing* const thing = pointer.shown();
  if (thing != nullptr && thing->scan == clouds.list[clouds.stripCloud].scan) {
    const auto [column, row] = clouds.strip->place(thing->point);
    mark = std::pair(rect.left + (column + 0.5) * rect.width / clouds.strip->image.width,
                     rect.top + (row + 0.5) * rect.height / clouds.strip->image.height);
  }
  const std::string caption =
      context.frame->scans[clouds.list[clouds.stripCloud].scan].name + ": " + describeStrip(*clouds.strip);
  bool pressed = false;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, ImGui::GetFontSize() * 0.2F});
  panelAt("##strip", panels.rooms.strip, false, [&] {
    ImGui::SetCursorPosX(ImGui::GetFontSize() * 0.5F);
    if (rect.top > panels.rooms.strip.top) ImGui::TextDisabled("%s", caption.c_str());
    panels.overStrip = imageAt(kStripImage, rect, mark);
    pressed = panels.overStrip && ImGui::IsMouseClicked(0);
  });
  ImGui::PopStyleVar();
  if (!pressed) return;
  if (auto picked = pointer.pickStrip(rect, pointer.x, pointer.y)) {
    pointer.lookAt(picked->place);
    pointer.pinned = pointer.inFull(std::move(*picked));
  }
}

void ViewSession::State::drawFrameBar() {
  const std::size_t requested = playback.requested();
  const FrameBar bar{.frame = requested,
                     .frames = playback.count(),
                     .key = context.source->keys()[requested],
                     .speed = playback.speedText(),
                     .busy = playback.busy(),
                     .playing = playback.playing(),
                     .damaged = playback.damaged()};
  const FrameBarUse use = frameBar(panels.rooms.bar, bar);
  if (use.play) togglePlaying();
  if (use.frame && *use.frame != requested) {
    playback.stop();
    goTo(*use.frame, *use.frame > requested ? 1 : -1);
  }
}

void ViewSession::State::drawPrompt() {
  constexpr std::size_t kMost = 200;
  const float letter = ImGui::GetFontSize();
  const float middle = static_cast<float>(panels.rooms.body.left) + static_cast<float>(panels.rooms.body.width) / 2;
  const auto wide = static_cast<float>(panels.rooms.body.width);
  const auto high = static_cast<float>(panels.rooms.body.height);
  ImGui::SetNextWindowPos({middle, static_cast<float>(panels.rooms.body.top) + letter}, ImGuiCond_Always, {0.5F, 0});
  ImGui::SetNextWindowSize({std::min(letter * 28, wide), std::min(letter * 22, high - 2 * letter)});
  ImGui::Begin("Go to sample", nullptr,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings);
  ImGui::TextDisabled("a key, a part of one, or #index from 0");
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::IsAnyItemActive()) ImGui::SetKeyboardFocusHere();
  const bool entered = ImGui::InputText("##key", &*panels.prompt, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::Separator();
  std::size_t found = 0;
  std::optional<std::string> chosen;
  const bool byIndex = panels.prompt->starts_with('#');
  for (std::size_t i = 0; i < context.source->keys().size(); ++i) {
    const std::string& key = context.source->keys()[i];
    const bool fits =
        byIndex ? fmt::format("#{}", i).starts_with(*panels.prompt) : key.find(*panels.prompt) != std::string::npos;
    if (!fits) continue;
    if (found++ < kMost && ImGui::Selectable(key.c_str())) chosen = key;
  }
  if (found > kMost) ImGui::TextDisabled("and %s more", grouped(found - kMost).c_str());
  if (found == 0) ImGui::TextDisabled("no key holds this");
  ImGui::End();
  if (entered) chosen = *panels.prompt;
  if (ImGui::IsKeyPressed(ImGuiKey_Escape) || (entered && panels.prompt->empty())) return panels.prompt.reset();
  if (!chosen) return;
  try {
    goTo(findFrame(*context.source, *chosen), 1);
    panels.prompt.reset();
  } catch (const InputError& e) {
    context.say(e.what());
  }
}

// Lists the sample's scans with their datasets, sensors and methods.
void ViewSession::State::drawSources() {
  for (std::size_t s = 0; s < context.frame->scans.size(); ++s) {
    const ViewScan& scan = context.frame->scans[s];
    NamedValues rows{
        {"from", wholeName(scan, context.source->title())}, {"sensor", scan.sensor}, {"method", scan.method}};
    rows.emplace_back("points", grouped(scan.scan.size()));
    if (scan.scan.rings > 0) rows.emplace_back("beams", fmt::format("{} x {}", scan.scan.rings, scan.scan.columns));
    if (scan.worldFromSensor) {
      const Vec3d& place = scan.worldFromSensor->translation;
      rows.emplace_back("stands at", fmt::format("{:.2f}, {:.2f}, {:.2f} m", place.x, place.y, place.z));
    }
    std::erase_if(rows, [](const auto& row) { return row.second.empty(); });
    valueRows(fmt::format("open {}", s).c_str(), rows);
    if (s + 1 < context.frame->scans.size()) ImGui::Separator();
  }
}

// Draws the tooltip beside the pointer.
void ViewSession::State::drawTips() {
  const bool told = pointer.pinned && pointer.hover && pointer.pinned->scan == pointer.hover->scan &&
                    pointer.pinned->point == pointer.hover->point;
  if (pointer.hover && !told && !pointer.measuring && !panels.help)
    tip(pointer.hover->heading, pointer.colorOf(*pointer.hover), pointer.hover->brief, pointer.hover->alarm);
}

void ViewSession::State::drawInstances() {
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
  for (const InstanceSummary& instance : scenery.instances()) rows.push_back(&instance);
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
      const std::string name = className(context.source->ontology(), classOf(instance)) + "##row";
      const bool marked = pointer.pinned && pointer.instanceOf(*pointer.pinned) == instance.id;
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
  pointer.pinned = pointer.inFull(pointer.pickedPoint(0, chosen->points[chosen->points.size() / 2]));
  pointer.lookAt(chosen->levelFromBox.translation);
  context.changes.panels = true;
}

}  // namespace scanmill
