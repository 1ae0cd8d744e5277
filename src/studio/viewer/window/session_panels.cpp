// Menus and panels. They execute the same actions as keys.

#include <fmt/core.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "base/grouped.h"
#include "viewer/picture.h"
#include "viewer/scale_ticks.h"
#include "viewer/window/picked_rows.h"
#include "viewer/window/session_state.h"

namespace scanmill {

// Runs all panels once and executes what the user has clicked.
void ViewSession::State::runPanels() {
  toolkit.suit(options.background);
  toolkit.frame([&] { drawPanels(); });
}

void ViewSession::State::drawPanels() {
  overStrip = false;
  drawLabels(labels, {0, rooms.body.top, canvas.width(), canvas.height() - rooms.body.top});
  for (std::size_t v = 0; v < std::min(panes.size(), views.size()); ++v) {
    drawMessage(views[v].rect, panes[v].message);
    if (panes.size() > 1 && !options.bare) drawCaption(views[v].rect, panes[v].caption, panes[v].active);
  }
  if (options.bare) return;
  options.still ? titleRow(rooms.title, title(), summary()) : drawMenus();
  panelAt("##side", rooms.side, !options.still, [&] {
    if (!options.still) drawColumns();
    drawLegends(true);
    if (pinned) {
      section("Point", options.still, [&] {
        heading(pinned->heading, colorOf(*pinned));
        valueRows("point", pinned->rows, pinned->alarm);
      });
    }
    if (!options.still && !clouds.empty()) {
      const bool known = !frame->scans[clouds.front().scan].scan[kInstance].empty();
      if (known) folded("Instances", [&] { drawInstances(); });
      folded("Scans", [&] { drawSources(); });
    }
    drawLegends(false);
  });
  drawStrip();
  if (!options.still) {
    drawFrameBar();
    std::vector<std::string> said;
    for (const ViewNotice& notice : notices) said.push_back(notice.text);
    if (messages(rooms.body, problems(), said)) {  // problems of the frame itself are still shown
      colorProblem.clear();
      meshProblem.clear();
      stripProblem.clear();
      instanceProblem.clear();
      hudChanged = true;
    }
    if (prompt) drawPrompt();
    if (help && !helpWindow(viewKeys())) help = false;
  }
  drawTips();
}

// True if the option that the action switches is on.
bool ViewSession::State::isOn(KeyAction action) {
  if (const bool* const option = switchOf(action).first) return *option;
  switch (action) {
    case KeyAction::ToggleMesh:
      return meshOn();
    case KeyAction::ToggleRangeImage:
      return options.rangeImage;
    case KeyAction::ToggleOverlay:
      return overlaid();
    case KeyAction::ToggleSplit:
      return options.layout == ViewLayout::Split;
    case KeyAction::ToggleWorld:
      return world;
    case KeyAction::InstanceAlone:
      return !aloneInstances.empty();
    default:
      return false;
  }
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
    const std::string lacks = source->isScene() ? sceneLacks(command.meaning) : "";
    const bool on = isOn(command.meaning.action);
    if (ImGui::MenuItem(command.label.c_str(), keysText(command).c_str(), on, lacks.empty())) act(command.meaning);
  }
  if (drawn) ImGui::EndMenu();
  const std::string text = fmt::format("{}   {}", title(), summary());
  const float wide = ImGui::CalcTextSize(text.c_str()).x;
  const float left = static_cast<float>(canvas.width()) - wide - ImGui::GetFontSize();
  ImGui::SameLine(std::max(left, ImGui::GetCursorPosX() + ImGui::GetFontSize()));
  ImGui::TextUnformatted(title().c_str());
  ImGui::SameLine();
  ImGui::TextDisabled("%s", summary().c_str());
  ImGui::EndMainMenuBar();
}

// Draws the list of quantities that colours can show: those of colorNames(), and the scan's foreign columns.
void ViewSession::State::drawColumns() {
  std::vector<ColorBy> all;
  std::string shown;
  if (source->isScene()) {
    for (const std::string_view name : kMeshColorNames) all.emplace_back(std::string(name));
    shown = kMeshColorNames[static_cast<std::size_t>(meshColor)];
  } else if (!clouds.empty() && !overlaid()) {
    const std::size_t view = activeView.value_or(0);
    const auto cloud = std::ranges::find(clouds, view, &ShownCloud::view);
    if (cloud == clouds.end()) return;
    const ViewScan& scan = frame->scans[cloud->scan];
    for (const ColorBy& by : colorsOf(scan.scan)) {
      if (hasColor(scan, by)) all.push_back(by);
    }
    shown = colorOf(view).name();
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

// Draws the legends that are scales, or those that are rows.
void ViewSession::State::drawLegends(bool ofScales) {
  const bool choose = !options.still && !overlaid() && !clouds.empty();
  const auto blocks = legends;  // a copy, since a click changes `legends`
  for (const LegendBlock& block : blocks) {
    const Legend& legend = block.legend;
    if (legend.scale != ofScales) continue;
    std::string name = legend.scale ? scaleTitle(legend) : legend.title;
    if (blocks.size() > 1 && frame && frame->scans.size() > 1) {
      name += ": " + panes[block.views.front()].caption;
    }
    section(name, options.still, [&] {
      if (legend.scale) {
        const auto range = scaleBar(legend, !choose);
        if (!range) return;
        for (const std::size_t view : block.views) {
          scales[view] = range;
          recolor(view);
        }
        return;
      }
      std::vector<bool> hidden;
      for (const LegendEntry& entry : legend.entries) hidden.push_back(isHidden(entry));
      const bool clickable =
          std::ranges::any_of(legend.entries, [](const LegendEntry& entry) { return entry.id >= 0; });
      const LegendUse use = legendRows(legend, hidden, clickable, options.still);
      if (use.all) act({KeyAction::ShowAllClasses});
      if (use.entry) pressLegend(legend.entries[*use.entry], toolkit.shift() || toolkit.clicks() == 2);
    });
  }
}

PixelRect ViewSession::State::stripRect() const {
  const int caption = static_cast<int>(std::lround(toolkit.letter() * 1.5));
  PixelRect rect = rooms.strip;
  if (rect.height > 2 * caption) {
    rect.top += caption;
    rect.height -= caption;
  }
  return rect;
}

void ViewSession::State::drawStrip() {
  if (!strip || rooms.strip.height < 1) return;
  const PixelRect rect = stripRect();
  std::optional<std::pair<double, double>> mark;
  const std::optional<PickedThing>& thing = hover ? hover : pinned;
  if (thing && thing->scan == clouds[stripCloud].scan) {
    const auto [column, row] = strip->place(thing->point);
    mark = std::pair(rect.left + (column + 0.5) * rect.width / strip->image.width,
                     rect.top + (row + 0.5) * rect.height / strip->image.height);
  }
  std::string caption = frame->scans[clouds[stripCloud].scan].name + ": " + describeStrip(*strip, options.stripOrder);
  if (!options.still) {
    caption += options.stripOrder == StripOrder::Outward ? " (I: as the sensor orders it)" : " (I: looking outward)";
  }
  bool pressed = false;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, ImGui::GetFontSize() * 0.2F});
  panelAt("##strip", rooms.strip, false, [&] {
    ImGui::SetCursorPosX(ImGui::GetFontSize() * 0.5F);
    if (rect.top > rooms.strip.top) ImGui::TextDisabled("%s", caption.c_str());
    overStrip = imageAt(kStripImage, rect, mark);
    pressed = overStrip && ImGui::IsMouseClicked(0);
  });
  ImGui::PopStyleVar();
  if (!pressed) return;
  if (auto picked = pickStrip(pointerX, pointerY)) {
    OrbitCamera turned = camera;
    turned.lookAt(picked->place);
    setCamera(turned);
    pinned = inFull(std::move(*picked));
  }
}

void ViewSession::State::drawFrameBar() {
  FrameBar bar;
  bar.frame = wanted;
  bar.frames = source->keys().size();
  bar.key = source->keys()[wanted];
  bar.speed = speedText();
  bar.busy = busy;
  bar.playing = playing;
  bar.damaged = damaged;
  const FrameBarUse use = frameBar(rooms.bar, bar);
  if (use.play) togglePlaying();
  if (use.frame && *use.frame != wanted) {
    playing = false;
    goTo(*use.frame, *use.frame > wanted ? 1 : -1);
  }
}

void ViewSession::State::drawPrompt() {
  constexpr std::size_t kMost = 200;
  const float letter = ImGui::GetFontSize();
  const float middle = static_cast<float>(rooms.body.left) + static_cast<float>(rooms.body.width) / 2;
  const auto wide = static_cast<float>(rooms.body.width);
  const auto high = static_cast<float>(rooms.body.height);
  ImGui::SetNextWindowPos({middle, static_cast<float>(rooms.body.top) + letter}, ImGuiCond_Always, {0.5F, 0});
  ImGui::SetNextWindowSize({std::min(letter * 28, wide), std::min(letter * 22, high - 2 * letter)});
  ImGui::Begin("Go to sample", nullptr,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings);
  ImGui::TextDisabled("a key, a part of one, or #index from 0");
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::IsAnyItemActive()) ImGui::SetKeyboardFocusHere();
  const bool entered = ImGui::InputText("##key", &*prompt, ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::Separator();
  std::size_t found = 0;
  std::optional<std::string> chosen;
  const bool byIndex = prompt->starts_with('#');
  for (std::size_t i = 0; i < source->keys().size(); ++i) {
    const std::string& key = source->keys()[i];
    const bool fits = byIndex ? fmt::format("#{}", i).starts_with(*prompt) : key.find(*prompt) != std::string::npos;
    if (!fits) continue;
    if (found++ < kMost && ImGui::Selectable(key.c_str())) chosen = key;
  }
  if (found > kMost) ImGui::TextDisabled("and %s more", grouped(found - kMost).c_str());
  if (found == 0) ImGui::TextDisabled("no key holds this");
  ImGui::End();
  if (entered) chosen = *prompt;
  if (ImGui::IsKeyPressed(ImGuiKey_Escape) || (entered && prompt->empty())) return prompt.reset();
  if (!chosen) return;
  try {
    goTo(findFrame(*source, *chosen), 1);
    prompt.reset();
  } catch (const InputError& e) {
    say(e.what());
  }
}

// Lists the datasets, sensors and methods of the sample.
void ViewSession::State::drawSources() {
  for (std::size_t s = 0; s < frame->scans.size(); ++s) {
    const ViewScan& scan = frame->scans[s];
    NamedValues rows{{"from", wholeName(scan, source->title())}, {"sensor", scan.sensor}, {"method", scan.method}};
    rows.emplace_back("points", grouped(scan.scan.size()));
    if (scan.scan.rings > 0) rows.emplace_back("beams", fmt::format("{} x {}", scan.scan.rings, scan.scan.columns));
    if (scan.worldFromSensor) {
      const Vec3d& place = scan.worldFromSensor->translation;
      rows.emplace_back("stands at", fmt::format("{:.2f}, {:.2f}, {:.2f} m", place.x, place.y, place.z));
    }
    std::erase_if(rows, [](const auto& row) { return row.second.empty(); });
    valueRows(fmt::format("open {}", s).c_str(), rows);
    if (s + 1 < frame->scans.size()) ImGui::Separator();
  }
}

// Draws a few rows beside the pointer.
void ViewSession::State::drawTips() {
  const bool told = pinned && hover && pinned->scan == hover->scan && pinned->point == hover->point;
  if (hover && !told && !measuring && !help) tip(hover->heading, colorOf(*hover), hover->brief, hover->alarm);
}

}  // namespace scanmill
