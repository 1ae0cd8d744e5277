#pragma once

// How charts look.

#include <cstddef>
#include <string>

namespace scanmill {

inline constexpr std::size_t kChartColors = 8;

// <style> of a chart; its rules hold for what is inside class "smc" alone.
std::string chartStyle();

}  // namespace scanmill
