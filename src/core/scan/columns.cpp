#include "scan/columns.h"

#include <fmt/format.h>

namespace scanmill {

std::string_view nameOf(ColumnType type) {
  return type == ColumnType::Float32  ? "float32"
         : type == ColumnType::UInt8  ? "uint8"
         : type == ColumnType::UInt16 ? "uint16"
                                      : "uint32";
}

std::vector<std::string> ColumnSet::names() const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    if (has(i)) names.emplace_back(kColumns[i].name);
  }
  return names;
}

std::vector<std::string> scanColumnNames(ColumnSet columns) {
  std::vector<std::string> names{"x", "y", "z"};
  for (std::string& name : columns.names()) names.push_back(std::move(name));
  return names;
}

std::string withUnit(std::string_view text, std::string_view unit) {
  return unit.empty() ? std::string(text) : fmt::format("{} ({})", text, unit);
}

std::string displayText(const Column& column, double value) {
  const ColumnDisplay& display = column.display;
  const double shown = value * display.factor;
  std::string text = column.type != ColumnType::Float32 ? fmt::format("{:.0f}", shown)
                     : display.decimals < 0             ? fmt::format("{:.5g}", shown)
                                                        : fmt::format("{:.{}f}", shown, display.decimals);
  if (!display.unit.empty()) text += fmt::format(" {}", display.unit);
  return text;
}

}  // namespace scanmill
