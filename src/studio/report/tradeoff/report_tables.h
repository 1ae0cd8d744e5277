#pragma once

// Writes the tables of a study's report as HTML; a table is empty where there is nothing to show.

#include <string>

#include "study/tradeoff/study.h"

namespace scanmill {

std::string settingsTable(const Study& study);
std::string classesTable(const Study& study);
std::string placesTable(const Study& study);
std::string stagesTables(const Study& study);  // a table per method: the time of each stage, of those after tracing too
std::string encodingsTable(const Study& study);
std::string sensingTable(const Study& study);
std::string ringsTable(const Study& study);
std::string assignmentsTable(const Study& study);  // the argument of --set that makes a pipeline use each setting

}  // namespace scanmill
