#pragma once

// The planes of an EXR image, one at a time, with their values under the pointer.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/ontology.h"
#include "viewer/canvas/canvas.h"

namespace scanmill {

class ImageSession {
 public:
  // Reads the file. Throws InputError for one that cannot be read, or a plane that it lacks (`plane`: its name; empty:
  // the first).
  ImageSession(const std::filesystem::path& file, const Ontology* ontology, Canvas& canvas, const std::string& plane,
               bool bare);
  ~ImageSession();
  ImageSession(const ImageSession&) = delete;
  ImageSession& operator=(const ImageSession&) = delete;

  // False: it wants to be closed.
  bool handle(const CanvasEvent& event);
  // Draws it.
  void settle();
  // What settle() has drawn.
  Image picture();
  // The name of every plane and its value at a pixel of the canvas; none beside the image.
  std::optional<std::vector<std::pair<std::string, std::string>>> pick(int x, int y) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
