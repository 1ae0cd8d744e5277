// Draws the table of the instances in the first scan that is shown.

#include <imgui.h>

#include <algorithm>
#include <array>

#include "base/grouped.h"
#include "viewer/color_map.h"
#include "viewer/window/session_state.h"

namespace scanmill {

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
