#pragma once

// Chooses the settings that the report of a study shows, with their words and colours.

#include <cstddef>
#include <string>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the words for a group of BeamErrors::byPlace: "away from edges" or "at edges".
std::string placeText(const std::string& group);

using Groups = std::vector<ErrorGroup> BeamErrors::*;
// Returns the names of the groups in which these settings have beams, in the order of the groups.
std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings, Groups groups);

// Returns the settings that stand out, at most `most`, as indices into Study::settings: the methods' defaults, the
// fastest setting of each method, the Pareto fronts of study_figures.h.
std::vector<std::size_t> shownSettings(const Study& study, std::size_t most);
// Returns all measured settings, or the settings that stand out if there are more than `most`, method by method.
std::vector<std::size_t> settingsByMethod(const Study& study, std::size_t most);

// Returns the index of a method's colour in the charts' palette, the same in every chart of every report.
std::size_t methodColor(const Study& study, const std::string& method);
// Returns distinct colours for settings of these methods: the first setting of each method takes the method's colour.
std::vector<std::size_t> settingColors(const Study& study, const std::vector<std::string>& methods);

}  // namespace scanmill
