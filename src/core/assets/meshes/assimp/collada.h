#pragma once

// Searches COLLADA files (.dae; COLLADA 1.4.1 and 1.5) for facts that the assimp library does not report.

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/format_support.h"

namespace scanmill {

const FormatSupport& colladaFormat();

// A material, as its effect states it.
struct ColladaMaterial {
  bool colored = false;                // true: `diffuse` is a colour or an image
  bool clamps = false;                 // true: a sampler clamps or mirrors its image
  bool inverted = false;               // true: beams pass where the image of `transparent` is bright or opaque
  std::optional<double> transparency;  // the number of `transparency`, if `transparent` is an image
};

struct ColladaFacts {
  char up = 'y';                           // axis of `up_axis`
  double unit = 0;                         // metres per unit; 0: not stated
  std::set<std::string> hidden;            // ids of nodes with `visibility` 0, which Maya and 3ds Max write
  std::vector<ColladaMaterial> materials;  // those of `text` that have an effect, sorted by their ids, as by assimp
  LeftOut leftOut;
  // The file's text for assimp, with changes: hidden nodes without an id have one; `lookat` has an up direction at
  // right angles to the view, and `up_axis` no blanks; morph targets are cut off, of which assimp reads none;
  // `texcoord` of images names the set of texture coordinates by its index.
  std::string text;
};

// Finds the facts in the text of the file, which is not checked further.
// Throws an Error that states the problem if the file has elements that assimp cannot read.
ColladaFacts colladaFacts(const std::filesystem::path& file);

}  // namespace scanmill
