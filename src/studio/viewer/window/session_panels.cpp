// Draws menus and panels. Menus and buttons execute the same actions as keys.

#include <fmt/core.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "base/short_text.h"
#include "viewer/window/session.h"

namespace scanmill {

// Draws all panels once and executes what the user has clicked.
void ViewSession::runPanels() {
  panels_.imgui.frame([&] { drawPanels(); });
}

// Draws labels and captions of the views, then the panels. A picture has a title instead of menus, and no controls.
void ViewSession::drawPanels() {
  panels_.overStrip = false;
  drawLabels(panels_.labels);
  for (std::size_t v = 0; v < std::min(panels_.panes.size(), context_.redraw.views().size()); ++v) {
    const PixelRect& view = context_.redraw.views()[v].rect;
    drawMessage(view, panels_.panes[v].message);
    if (panels_.panes.size() > 1) drawCaption(view, panels_.panes[v].caption, panels_.panes[v].active);
  }
  if (context_.options.bare) return;
  context_.options.still ? titleRow(panels_.rects.title, panels_.title(), panels_.summary()) : drawMenus();
  panelAt("##side", panels_.rects.side, panelUse(), [&] { drawSidePanel(); });
  drawStrip();
  if (!context_.options.still) {
    drawFrameBar();
    drawMessagesOfSession();
    if (panels_.prompt) drawPrompt();
    if (panels_.help && !helpWindow(viewKeys())) panels_.help = false;
  }
  drawTooltip();
}

// Draws the legends with scales at the top, and the lists of entries, which may be long, at the bottom.
void ViewSession::drawSidePanel() {
  if (!context_.options.still) drawColorMenu();
  drawLegends(LegendKind::Scale);
  if (pointer_.pinned) {
    section("Point", panelUse(), [&] {
      heading(pointer_.pinned->heading, pointer_.colorOf(*pointer_.pinned));
      valueRows("point", pointer_.pinned->rows, pointer_.pinned->alarm);
    });
  }
  if (!context_.options.still && !clouds_.list.empty()) {
    const bool hasInstances = !clouds_.scanOf(clouds_.list.front()).scan[kInstance].empty();
    if (hasInstances && ImGui::CollapsingHeader("Instances")) drawInstances();
  }
  drawLegends(LegendKind::Entries);
}

// Draws problems and notices. A click removes all problems except those of the frame.
void ViewSession::drawMessagesOfSession() {
  std::vector<std::string> notices;
  for (const ViewNotice& notice : context_.notices) notices.push_back(notice.text);
  if (!drawMessages(panels_.rects.body, problems(), notices)) return;
  for (std::string* problem :
       {&clouds_.colorProblem, &sceneView_.meshProblem, &clouds_.stripProblem, &clouds_.instanceProblem}) {
    problem->clear();
  }
  context_.changes.panels = true;
}

// Draws the menus of all commands and, at the right end of their row, the title and the summary.
void ViewSession::drawMenus() {
  if (!ImGui::BeginMainMenuBar()) return;
  std::string_view menu;    // the menu of the last command
  bool isMenuOpen = false;  // true: the user has opened `menu`, and its commands are drawn
  for (const ViewCommand& command : commands()) {
    if (command.menu.empty()) continue;
    if (command.menu != menu) {
      if (isMenuOpen) ImGui::EndMenu();
      menu = command.menu;
      isMenuOpen = ImGui::BeginMenu(menu.data());
    }
    if (!isMenuOpen) continue;
    const bool isUsable = !context_.source->isScene() || command.whyNotInScene.empty();
    const bool isOn = command.isOn && command.isOn(*this);
    if (ImGui::MenuItem(command.label.c_str(), keysText(command).c_str(), isOn, isUsable)) execute(command);
  }
  if (isMenuOpen) ImGui::EndMenu();
  const std::string text = fmt::format("{}   {}", panels_.title(), panels_.summary());
  const float textWidth = ImGui::CalcTextSize(text.c_str()).x;
  const float left = static_cast<float>(context_.canvas.width()) - textWidth - ImGui::GetFontSize();
  ImGui::SameLine(std::max(left, ImGui::GetCursorPosX() + ImGui::GetFontSize()));
  ImGui::TextUnformatted(panels_.title().c_str());
  ImGui::SameLine();
  ImGui::TextDisabled("%s", panels_.summary().c_str());
  ImGui::EndMainMenuBar();
}

// Draws the menu of quantities for colours: those of colorsOf() that the scan has; for a scene, kMeshColorNames.
void ViewSession::drawColorMenu() {
  std::vector<ColorBy> quantities;
  std::string shown;  // name of the quantity that colours show now
  if (context_.source->isScene()) {
    for (const std::string_view name : kMeshColorNames) quantities.emplace_back(std::string(name));
    shown = kMeshColorNames[static_cast<std::size_t>(sceneView_.meshColor)];
  } else if (!clouds_.list.empty() && !clouds_.overlaid()) {
    const std::size_t view = clouds_.activeView.value_or(0);
    const ShownCloud* const cloud = clouds_.inView(view);
    if (cloud == nullptr) return;
    const ViewScan& scan = context_.frame->scans[cloud->scan];
    for (const ColorBy& by : colorsOf(scan.scan)) {
      if (clouds_.hasColor(scan, by)) quantities.push_back(by);
    }
    shown = clouds_.colorOf(view).name();
  }
  if (quantities.empty()) return;
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (!ImGui::BeginCombo("##columns", ("colours: " + shown).c_str())) return;
  std::optional<ColorBy> chosen;
  for (const ColorBy& by : quantities) {
    if (ImGui::Selectable(by.name().c_str(), by.name() == shown)) chosen = by;
  }
  ImGui::EndCombo();
  if (chosen) chooseColor(*chosen);
}

// Draws the legends of one kind. What the user clicks or changes is applied at once.
void ViewSession::drawLegends(LegendKind kind) {
  const auto blocks = panels_.legends;  // a copy, since a click changes `legends`
  for (const LegendBlock& block : blocks) {
    const Legend& legend = block.legend;
    if (legend.scale != (kind == LegendKind::Scale)) continue;
    std::string title = legend.scale ? scaleTitle(legend) : legend.title;
    if (blocks.size() > 1 && context_.scanCount() > 1) {
      title += ": " + panels_.panes[block.views.front()].caption;
    }
    section(title, panelUse(), [&] { legend.scale ? drawScaleOf(block) : drawEntriesOf(legend); });
  }
}

// Draws the scale that some views share, and applies the ends that the user enters to these views.
void ViewSession::drawScaleOf(const LegendBlock& block) {
  const bool hasFields = !context_.options.still && !clouds_.overlaid() && !clouds_.list.empty();
  const auto ends = drawScale(block.legend, hasFields ? PanelUse::Interactive : PanelUse::Picture);
  if (!ends) return;
  for (const std::size_t view : block.views) {
    clouds_.scales[view] = ends;
    clouds_.recolor(view);
  }
}

// Draws the entries of a legend. A click on a class or scan hides or shows it; a double click or shift shows it alone.
void ViewSession::drawEntriesOf(const Legend& legend) {
  std::vector<bool> hidden;
  for (const LegendEntry& entry : legend.entries) hidden.push_back(panels_.isHidden(entry));
  const bool clickable = std::ranges::any_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
  const LegendClick click = drawLegendRows(legend, hidden, clickable, panelUse());
  if (click.allEntries) showAll();
  if (!click.entry || legend.entries[*click.entry].id < 0) return;
  const bool showsOnly = panels_.imgui.shift() || panels_.imgui.clicks() == 2;
  const std::int64_t id = legend.entries[*click.entry].id;
  if (clouds_.overlaid()) {
    std::set<std::string>& hiddenScans = context_.filter.hiddenScans;
    const std::string& clicked = context_.frame->scans[static_cast<std::size_t>(id)].name;
    if (showsOnly) {
      hiddenScans.clear();
      for (const ViewScan& scan : context_.frame->scans) hiddenScans.insert(scan.name);
      hiddenScans.erase(clicked);
    } else if (hiddenScans.erase(clicked) == 0) {
      hiddenScans.insert(clicked);
    }
  } else if (showsOnly) {
    context_.filter.classes.showOnly(static_cast<std::uint16_t>(id));
  } else {
    context_.filter.classes.toggle(static_cast<std::uint16_t>(id));
  }
  applyFilter();
}

// Draws the range image, with a ring around the point under the pointer or the clicked point. A click selects a point
// and turns the camera to this point.
void ViewSession::drawStrip() {
  if (!clouds_.strip || panels_.rects.strip.height < 1) return;
  const PixelRect rect = panels_.stripRect();
  std::optional<std::pair<double, double>> mark;  // centre of the ring (pixels of the canvas)
  const PickedElement* const marked = pointer_.hoveredOrPinned();
  if (marked != nullptr && marked->scan == clouds_.list[clouds_.stripCloud].scan) {
    const auto [column, row] = clouds_.strip->pixelPosition(marked->point);
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
  if (auto picked = pointer_.pickStrip(rect)) {
    pointer_.lookAt(picked->position);
    pointer_.pinned = pointer_.withOtherScans(std::move(*picked));
  }
}

// Draws the button that plays frames, the slider that chooses a frame, and the name of what is being loaded.
void ViewSession::drawFrameBar() {
  const std::size_t requested = playback_.requested();
  panelAt("##frames", panels_.rects.bar, PanelUse::Picture, [&] {
    const float lineHeight = ImGui::GetFontSize();
    const bool hasSeveralFrames = playback_.count() > 1;
    if (hasSeveralFrames) {
      if (ImGui::Button(playback_.playing() ? "Pause" : "Play", {lineHeight * 4, 0})) togglePlaying();
      ImGui::SameLine();
      const float width = ImGui::GetContentRegionAvail().x;
      ImGui::SetNextItemWidth(width < lineHeight * 30 ? width : width * 0.45F);
      const int last = static_cast<int>(playback_.count()) - 1;
      const int before = static_cast<int>(requested);
      int frame = before;  // SliderInt() changes it
      if (ImGui::SliderInt("##frame", &frame, 0, last, "", ImGuiSliderFlags_AlwaysClamp) && frame != before) {
        playback_.stop();
        goTo(static_cast<std::size_t>(std::clamp(frame, 0, last)), frame > before ? 1 : -1);
      }
      ImGui::SameLine();
      ImGui::AlignTextToFramePadding();
      textLine(fmt::format("#{} of {}   {}", requested, playback_.count(), context_.source->keys()[requested]));
    }
    if (playback_.busy().empty()) return;
    if (hasSeveralFrames) ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    dimText("loading " + playback_.busy());
  });
}

// Draws the window that asks for a frame: a field for a part of the key or the index, and a list of the frames that
// match what the user has typed so far. A click or Return shows a frame; Escape closes the window.
void ViewSession::drawPrompt() {
  constexpr std::size_t kMost = 200;  // largest number of keys in the list
  const float lineHeight = ImGui::GetFontSize();
  const PixelRect& body = panels_.rects.body;
  const auto width = static_cast<float>(body.width), height = static_cast<float>(body.height);
  ImGui::SetNextWindowPos({static_cast<float>(body.left) + width / 2, static_cast<float>(body.top) + lineHeight},
                          ImGuiCond_Always, {0.5F, 0});
  ImGui::SetNextWindowSize({std::min(lineHeight * 28, width), std::min(lineHeight * 22, height - 2 * lineHeight)});
  ImGui::Begin("Go to sample", nullptr,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings);
  ImGui::TextDisabled("a key, a part of one, or #index from 0");
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::IsAnyItemActive()) ImGui::SetKeyboardFocusHere();
  const bool entered = ImGui::InputText("##key", &*panels_.prompt, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::Separator();
  std::size_t matches = 0;
  std::optional<std::string> chosen;
  const std::string& typed = *panels_.prompt;
  for (std::size_t i = 0; i < context_.source->keys().size(); ++i) {
    const std::string& key = context_.source->keys()[i];
    const bool isMatch =
        typed.starts_with('#') ? fmt::format("#{}", i).starts_with(typed) : key.find(typed) != std::string::npos;
    if (isMatch && matches++ < kMost && ImGui::Selectable(key.c_str())) chosen = key;
  }
  if (matches > kMost) ImGui::TextDisabled("and %s more", grouped(matches - kMost).c_str());
  if (matches == 0) ImGui::TextDisabled("no key holds this");
  ImGui::End();
  if (entered) chosen = *panels_.prompt;
  if (ImGui::IsKeyPressed(ImGuiKey_Escape) || (entered && panels_.prompt->empty())) return panels_.prompt.reset();
  if (!chosen) return;
  try {
    goTo(context_.source->find(*chosen), 1);
    panels_.prompt.reset();
  } catch (const InputError& e) {
    context_.notify(e.what());
  }
}

// Draws the tooltip beside the pointer, unless the point under the pointer is described in the side panel already.
void ViewSession::drawTooltip() {
  const std::optional<PickedElement>&hover = pointer_.hover, &pinned = pointer_.pinned;
  const bool isPinned = pinned && hover && pinned->scan == hover->scan && pinned->point == hover->point;
  if (hover && !isPinned && !pointer_.measuring && !panels_.help)
    tooltip(hover->heading, pointer_.colorOf(*hover), hover->brief, hover->alarm);
}

// Returns the instances in the order that the user has chosen for the table which is being drawn.
std::vector<const InstanceSummary*> ViewSession::sortedInstances() {
  std::vector<const InstanceSummary*> instances;
  for (const InstanceSummary& instance : sceneView_.instances()) instances.push_back(&instance);
  const ImGuiTableSortSpecs* const sort = ImGui::TableGetSortSpecs();
  if (sort == nullptr || sort->SpecsCount == 0) return instances;
  const auto valueOf = [&](const InstanceSummary* instance) {
    const std::array<double, 4> columns{static_cast<double>(classOf(*instance)), static_cast<double>(instance->id),
                                        static_cast<double>(instance->points.size()), instance->size.x};
    return columns.at(static_cast<std::size_t>(sort->Specs->ColumnIndex));
  };
  const bool descending = sort->Specs->SortDirection == ImGuiSortDirection_Descending;
  std::ranges::stable_sort(instances, {}, [&](const auto* i) { return descending ? -valueOf(i) : valueOf(i); });
  return instances;
}

// Draws a table of the first shown scan's instances. A click selects a point of an instance and turns the camera there.
void ViewSession::drawInstances() {
  constexpr int kVisibleRows = 14;
  constexpr ImGuiTableFlags kTable = ImGuiTableFlags_Sortable | ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                                     ImGuiTableFlags_NoSavedSettings | ImGuiTableFlags_SizingStretchProp;
  const float height = ImGui::GetTextLineHeightWithSpacing() * kVisibleRows;
  if (!ImGui::BeginTable("instances", 4, kTable, {0, height})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  // A first click on the heading of the columns "points" and "box (m)" sorts in descending order.
  constexpr ImGuiTableColumnFlags kUp = ImGuiTableColumnFlags_WidthStretch;
  constexpr ImGuiTableColumnFlags kDown = kUp | ImGuiTableColumnFlags_PreferSortDescending;
  ImGui::TableSetupColumn("class", kUp, 0.28F);  // the numbers are fractions of the table's width
  ImGui::TableSetupColumn("id", kUp, 0.12F);
  ImGui::TableSetupColumn("points", kDown, 0.19F);
  ImGui::TableSetupColumn("box (m)", kDown, 0.41F);
  ImGui::TableHeadersRow();
  const std::vector<const InstanceSummary*> rows = sortedInstances();
  ImGuiListClipper clipper;  // chooses the rows that the table's scroll position shows
  clipper.Begin(static_cast<int>(rows.size()));
  const InstanceSummary* chosen = nullptr;
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const InstanceSummary& instance = *rows[static_cast<std::size_t>(i)];
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::PushID(static_cast<int>(instance.id));
      const std::string name = className(context_.source->ontology(), classOf(instance)) + "##row";
      const bool isPinned = pointer_.pinned && pointer_.instanceOf(*pointer_.pinned) == instance.id;
      if (ImGui::Selectable(name.c_str(), isPinned, ImGuiSelectableFlags_SpanAllColumns)) chosen = &instance;
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
  const std::uint32_t middlePoint = chosen->points[chosen->points.size() / 2];
  pointer_.pinned = pointer_.withOtherScans(pointer_.pickedPoint(0, middlePoint));
  pointer_.lookAt(chosen->levelFromBox.translation);
  context_.changes.panels = true;
}

}  // namespace scanmill
