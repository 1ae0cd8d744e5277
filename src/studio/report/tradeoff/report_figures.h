#pragma once

// Which settings the report of a study shows, and in what words and colours.

#include <cstddef>
#include <string>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// The words for a group of BeamErrors::byPlace: "away from edges" or "at edges".
std::string placeText(const std::string& group);

using Groups = std::vector<ErrorGroup> BeamErrors::*;
// The names of the groups in which these settings have beams, in their order.
std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings, Groups groups);

// The settings that stand out, at most so many: the methods' defaults, the fastest of each method, the fronts of
// study_figures.h. The result holds indices into Study::settings.
std::vector<std::size_t> shownSettings(const Study& study, std::size_t most);
// All settings that were measured, or where there are more than `most` those that stand out, method by method.
std::vector<std::size_t> settingsByMethod(const Study& study, std::size_t most);

// The place of a method's colour in the charts' palette, the same in every chart of every report.
std::size_t methodColor(const Study& study, const std::string& method);
// Colours for settings of these methods, each its own: the first setting of each method takes the method's.
std::vector<std::size_t> settingColors(const Study& study, const std::vector<std::string>& methods);

}  // namespace scanmill
