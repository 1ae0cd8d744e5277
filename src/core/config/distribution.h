#pragma once

// A file may give a distribution in place of a value; the value is then drawn at random:
//
//   length: {uniform: [200, 400]}                      # all numbers between them are equally likely
//   slope: {normal: [1, 0.5], within: [0, 3]}          # mean and standard deviation, cut off outside of `within`
//   season: {choice: [summer, autumn, winter]}         # all are equally likely; [1, ..., 9] has nine items
//   traffic: {choice: [0, {uniform: [0.5, 2]}]}        # 0, or a number from 0.5 to 2
//   rate_mm_h: {uniform: [0, 30], per: frame}          # drawn anew for each frame, not for each sequence
//
// A normal distribution is also cut off at four standard deviations (one of 16,000 numbers would lie beyond), so that
// every drawn value has bounds.

#include <cstddef>
#include <string>
#include <vector>

#include "base/random.h"
#include "config/value.h"

namespace scanmill {

// The value that was drawn for a key. If an item of a choice holds distributions itself, `value` has their drawn
// values.
struct DrawnValue {
  std::string key;    // as --set names it: "objects.0.town.length"
  std::string value;  // as YAML on one line
  bool operator==(const DrawnValue&) const = default;
};

// True if the value itself is a distribution, valid or not.
bool isDistribution(const Value& value);
// True if the value, or anything within it, is a distribution.
bool holdsDistribution(const Value& value);
// Returns the first distribution within the value that is drawn for each frame; null if there is none.
const Value* findDrawnPerFrame(const Value& value);

// Returns the value with a drawn value in place of each distribution within it, and appends the drawn values to
// `draws`. `key` is the key of the value itself, empty for a whole file. A drawn value depends only on its key and on
// the address, and stays the same whatever else the file holds. Beam, number and purpose of the address are set here,
// and the frame becomes 0 for values that are drawn for each sequence. Throws InputError for an invalid distribution.
Value withDraws(const Value& value, const std::string& key, const RandomAddress& address,
                std::vector<DrawnValue>& draws);

// A distribution has ends: the least and the greatest number, or each item of a choice. In each of the cases 0 to
// countCases(value) - 1 every distribution within the value is at one of its ends, and every end occurs in some case. A
// reader that accepts all cases therefore accepts all drawn values, unless it checks how two numbers go together. The
// number of cases is 1 if nothing is drawn.
std::size_t countCases(const Value& value);
Value withCase(const Value& value, std::size_t number);

}  // namespace scanmill
