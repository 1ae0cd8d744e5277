#include "base/extent_text.h"

#include <fmt/format.h>

namespace scanmill {

std::string extentText(const Box& box) {
  if (box.empty()) return "-";
  const auto edge = [](double m) { return m >= 100 ? fmt::format("{:.0f}", m) : fmt::format("{:.3g}", m); };
  const Vec3d size = box.high - box.low;
  return fmt::format("{} x {} x {} m", edge(size.x), edge(size.y), edge(size.z));
}

}  // namespace scanmill
