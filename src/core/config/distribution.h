#pragma once

// Values of a file that are drawn at random in place of being written there:
//
//   length: {uniform: [200, 400]}                      # every number between them is as likely
//   slope: {normal: [1, 0.5], within: [0, 3]}          # mean and standard deviation, cut off outside of `within`
//   season: {choice: [summer, autumn, winter]}         # each is as likely; [1, ..., 9] are nine
//   traffic: {choice: [0, {uniform: [0.5, 2]}]}        # none, or some
//   rate_mm_h: {uniform: [0, 30], per: frame}          # drawn anew for each frame, not for each sequence
//
// A normal distribution is cut off at four standard deviations, too (one of 16,000 numbers would lie beyond), so that
// what may be drawn has bounds.

#include <cstddef>
#include <string>
#include <vector>

#include "base/random.h"
#include "config/value.h"

namespace scanmill {

// What was drawn for a key. An item of a choice that holds distributions itself is told with what they gave.
struct DrawnValue {
  std::string key;    // as --set names it: "objects.0.town.length"
  std::string value;  // as a file would have it
  bool operator==(const DrawnValue&) const = default;
};

// Whether the value itself is one, right or wrong.
bool isDistribution(const Value& value);
// Whether the value, or anything within it, is a distribution.
bool holdsDistribution(const Value& value);
// The first one within the value that is drawn for each frame; null where none is.
const Value* findDrawnPerFrame(const Value& value);

// The value with something drawn in place of each distribution within it, and these appended to `draws`. `key`: of the
// value itself, empty for a whole file. What is drawn follows from the key and the address, of which beam, number and
// purpose are set, and the frame is 0 for what is drawn for each sequence: it stays the same whatever else the file
// has. Throws InputError for a distribution that is none.
Value withDraws(const Value& value, const std::string& key, const RandomAddress& address,
                std::vector<DrawnValue>& draws);

// What may be drawn has ends: the least and the greatest number, each item of a choice. A reader that takes all of the
// cases 0 to countCases(value) - 1 takes whatever is drawn, unless it minds how two numbers go together: in each case
// every distribution within the value is at one of its ends, and each end has its turn. 1: nothing is drawn.
std::size_t countCases(const Value& value);
Value withCase(const Value& value, std::size_t number);

}  // namespace scanmill
