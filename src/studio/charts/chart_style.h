#pragma once

// The colours and fonts of charts.

#include <cstddef>
#include <string>

namespace scanmill {

inline constexpr std::size_t kChartColors = 8;

// The <style> of a chart. Its rules hold for what is inside of class "smc" alone.
std::string chartStyle();

}  // namespace scanmill
