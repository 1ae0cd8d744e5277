#pragma once

// Random values in files. This header is installed because scene/scene.h includes it.
//
//   const bool random = holdsDistribution(parseYaml("length: {uniform: [200, 400]}", "scene.yaml"));  // true
//
// A file may give a distribution in place of a value. The program then samples the value at random:
//
//   length: {uniform: [200, 400]}                      # all numbers between the two are equally likely
//   slope: {normal: [1, 0.5], within: [0, 3]}          # mean and standard deviation, cut off outside `within`
//   season: {choice: [summer, autumn, winter]}         # all items are equally likely; [1, ..., 9] has nine
//   road: {choice: [dry, wet], weights: [9, 1]}        # dry nine times as often
//   traffic: {choice: [0, {uniform: [0.5, 2]}]}        # 0, or a number from 0.5 to 2
//   rate_mm_h: {uniform: [0, 30], per: frame}          # a new value for each frame, not for each sequence
//   road: {choice: [dry, wet], stratify: split}        # half of the sequences of each split is wet
//
// A normal distribution is also cut off at four standard deviations, so that every random value has bounds; otherwise
// one of 16,000 numbers would be farther from the mean.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "config/value.h"

namespace scanmill {

struct RandomAddress;

// A scalar that was sampled for a key. A sampled map or list gives a DrawnValue for each scalar within it, with a key
// such as "effects.2.weather.rate_mm_h".
struct DrawnValue {
  std::string key;      // dotted key, as in --set: "objects.0.town.length"
  std::string value;    // the value as YAML on one line
  bool number = false;  // true: `value` is a number in JSON's notation
  bool operator==(const DrawnValue&) const = default;
};

// The position of a sequence in its split and of a frame in its split, for `stratify: split`.
struct PlaceInSplit {
  std::string split;
  std::uint64_t sequence = 0, sequences = 1;  // index of the sequence in its split; number of the split's sequences
  std::uint64_t frame = 0, frames = 1;        // index of the frame among all frames of the split; their number
};

// True if the value is a map with a key `uniform`, `normal` or `choice`, whether or not it is a valid distribution.
bool isDistribution(const Value& value);
// True if the value, or anything within it, is a distribution.
bool holdsDistribution(const Value& value);
// Returns the first distribution within the value that is sampled anew for each frame; null if there is none.
const Value* findDrawnPerFrame(const Value& value);
// Returns the first distribution within the value that has the key `stratify`; null if there is none.
const Value* findStratified(const Value& value);

// Returns a copy of the value in which a random value replaces each distribution, and appends the random values to
// `draws`. `key` is the dotted key of `value` in its file, empty for a complete file. A random value depends only on
// its own key and on `address`, whatever else the file contains. The function sets the beam, the number and the purpose
// of the address itself, and sets the frame to 0 for values that are sampled once per sequence. Throws InputError for
// an invalid distribution.
//
// Values of a distribution with `stratify: split` are spread evenly over the n sequences (or frames) of the split: its
// quantiles are n numbers at equal distances with one random offset, in random order (systematic sampling: Cochran,
// Sampling Techniques, 1977, chapter 8). An item of probability p then occurs n p times, rounded up or down. Such a
// value depends on `place`, too.
Value withDraws(const Value& value, const std::string& key, const RandomAddress& address,
                std::vector<DrawnValue>& draws, const PlaceInSplit& place = {});

// The ends of a distribution are its least and greatest number, also for a choice such as [1, ..., 9]; the ends of any
// other choice are its items. withCase() replaces each distribution within the value by one of its ends; over the cases
// 0 to countCases(value) - 1, every end occurs. A reader that accepts all cases therefore accepts all random values,
// unless it checks two values against each other. A value without distributions has one case.
std::size_t countCases(const Value& value);
[[nodiscard]] Value withCase(const Value& value, std::size_t caseNumber);

}  // namespace scanmill
