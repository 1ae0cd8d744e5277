#pragma once

// Loads frames and scenes on a thread of its own, so that the window never waits.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"

namespace scanmill {

class FrameLoader {
 public:
  // Keeps frames up to so many bytes (the last used stay), at least the one that is wanted.
  explicit FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t keptBytes = std::uint64_t{1} << 30);
  ~FrameLoader();  // waits for what is being loaded
  FrameLoader(const FrameLoader&) = delete;
  FrameLoader& operator=(const FrameLoader&) = delete;

  // This frame is wanted next, then those after it in the direction of `step` (1 or -1), as far as half of the room
  // goes (the other half is for what was seen), and at most 64. What was wanted before and is not begun is forgotten.
  void want(std::size_t frame, int step = 1);
  // Null while it is not loaded.
  std::shared_ptr<const ViewFrame> frame(std::size_t frame);
  // Waits for it.
  std::shared_ptr<const ViewFrame> wait(std::size_t frame);

  // The mesh of a scene; frames go first. One is kept. Null while it is not loaded.
  void wantMesh(const SceneChoice& scene);
  std::shared_ptr<const ViewMesh> mesh(const SceneChoice& scene);
  std::shared_ptr<const ViewMesh> waitMesh(const SceneChoice& scene);

  // What is asked for and not there yet, for people: "street-s1-lane-000012", "scene street"; empty: nothing.
  std::string busy() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
