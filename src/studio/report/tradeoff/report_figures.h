#pragma once

// Chooses the settings that a trade-off report shows, and their names and colours.

#include <cstddef>
#include <string>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the text for a group of BeamErrors::byPlace: "away from edges" or "at edges".
std::string placeText(const std::string& group);

using Groups = std::vector<ErrorGroup> BeamErrors::*;
// Returns the names of the groups in which at least one of the settings has beams, in the order of the groups.
std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings, Groups groups);

// Returns at most `most` noteworthy settings as indices in Study::settings: the methods with their defaults, the
// fastest setting of each method, and the Pareto fronts of study_figures.h.
std::vector<std::size_t> shownSettings(const Study& study, std::size_t most);
// Returns the indices of all measured settings, grouped by method; if there are more than `most`, only noteworthy
// settings.
std::vector<std::size_t> settingsByMethod(const Study& study, std::size_t most);

// Returns the index of a method's colour in the charts' palette. All charts of a report use this colour for the method.
std::size_t methodColor(const Study& study, const std::string& method);
// Returns colours (indices in the palette) for settings with these methods; all differ if the palette has enough.
// The first setting of each method gets the method's colour.
std::vector<std::size_t> settingColors(const Study& study, const std::vector<std::string>& methods);

}  // namespace scanmill
