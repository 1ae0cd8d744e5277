// The instances of the first scan that is shown: their table and boxes; and the returns of one beam.

#include <fmt/core.h>
#include <imgui.h>

#include <algorithm>

#include "base/grouped.h"
#include "viewer/window/guides.h"
#include "viewer/window/session_state.h"

namespace scanmill {

namespace {

std::uint16_t classOf(const InstanceSummary& instance) {
  return instance.classes.empty() ? std::uint16_t{0} : instance.classes.front().first;
}

// Returns the points of a beam, the nearest first.
std::vector<Vec3f> returnsOf(const Scan& scan, std::size_t point) {
  if (!knowsBeams(scan) || (scan.organised ? scan.planes < 2 : scan[kReturn].empty())) return {};
  const PointKey own = keyOf(scan, point);
  std::vector<Vec3f> places;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const PointKey key = keyOf(scan, i);
    if (key.ring == own.ring && key.column == own.column && isFinite(scan.position[i])) {
      places.push_back(scan.position[i]);
    }
  }
  std::ranges::sort(places, {}, [](const Vec3f& p) { return length(Vec3d(p)); });
  return places;
}

}  // namespace

const std::vector<InstanceSummary>& ViewSession::State::instances() {
  const ShownCloud& cloud = clouds.front();
  const std::pair<const ViewFrame*, std::size_t> of{frame.get(), cloud.scan};
  if (instancesOf != of) {
    allInstances = summarizeInstances(frame->scans[cloud.scan].scan, cloud.canvasFromScan);
    instancesOf = of;
  }
  return allInstances;
}

// Adds the smallest upright box about each instance's points, in the colour of its class.
void ViewSession::State::placeInstanceBoxes(LineSet& lines) {
  if (!instanceBoxes || clouds.empty() || !frame->objects.empty()) return;
  for (const InstanceSummary& instance : instances()) {
    const std::uint16_t semantic = classOf(instance);
    const bool alone = aloneInstances.empty() || aloneInstances.contains(instance.id);
    if (!alone || !filter.shows(semantic)) continue;
    addBox(lines, instance.levelFromBox, instance.size, false, classColor(source->ontology(), semantic));
  }
}

void ViewSession::State::drawInstances() {
  constexpr int kRows = 14;
  constexpr ImGuiTableFlags kTable = ImGuiTableFlags_Sortable | ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                                     ImGuiTableFlags_NoSavedSettings | ImGuiTableFlags_SizingStretchProp;
  const float high = ImGui::GetTextLineHeightWithSpacing() * kRows;
  if (!ImGui::BeginTable("instances", 4, kTable, {0, high})) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  // The columns of points and sizes sort in descending order first.
  for (const auto& [name, share] : {std::pair("class", 0.28F), {"id", 0.12F}, {"points", 0.19F}, {"box (m)", 0.41F}}) {
    const bool large = name[0] == 'p' || name[0] == 'b';
    ImGui::TableSetupColumn(
        name, ImGuiTableColumnFlags_WidthStretch | (large ? ImGuiTableColumnFlags_PreferSortDescending : 0), share);
  }
  ImGui::TableHeadersRow();
  std::vector<const InstanceSummary*> rows;
  for (const InstanceSummary& instance : instances()) rows.push_back(&instance);
  if (const ImGuiTableSortSpecs* const sort = ImGui::TableGetSortSpecs(); sort != nullptr && sort->SpecsCount > 0) {
    const auto value = [&](const InstanceSummary* instance) {
      switch (sort->Specs->ColumnIndex) {
        case 0:
          return static_cast<double>(classOf(*instance));
        case 1:
          return static_cast<double>(instance->id);
        case 2:
          return static_cast<double>(instance->points.size());
        default:
          return instance->size.x;
      }
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
      const std::string name = className(source->ontology(), classOf(instance)) + "##row";
      const bool marked = pinned && instanceOf(*pinned) == instance.id;
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
  pinned = inFull(pickedPoint(0, chosen->points[chosen->points.size() / 2]));
  OrbitCamera turned = camera;
  turned.lookAt(chosen->levelFromBox.translation);
  setCamera(turned);
  hudChanged = true;
}

// Draws a line through the returns of the beam that is under the pointer or was clicked.
void ViewSession::State::placeBeam() {
  const std::optional<PickedThing>& thing = hover ? hover : pinned;
  std::optional<std::pair<std::size_t, std::size_t>> beam;
  if (thing && thing->scan != kNoScan) beam.emplace(thing->scan, thing->point);
  if (beam == beamOf && !itemsChanged) return;  // the search for returns reads the whole scan
  beamOf = beam;
  constexpr Rgb kBeam{255, 220, 80};
  LineSet lines;
  for (const ShownCloud& cloud : clouds) {
    if (!beam || cloud.scan != beam->first) continue;
    const std::vector<Vec3f> places = returnsOf(frame->scans[cloud.scan].scan, beam->second);
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      lines.add(cloud.canvasFromScan * Vec3d(places[i]), cloud.canvasFromScan * Vec3d(places[i + 1]), kBeam);
    }
    break;
  }
  if (lines.colors.empty() && !beamDrawn) return;
  beamDrawn = !lines.colors.empty();
  setLines(kBeamItem, lines, 2);
  lightChanged = true;
}

}  // namespace scanmill
