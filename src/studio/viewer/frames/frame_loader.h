#pragma once

// Loads frames and scenes on a thread of its own, so that the window never waits for them.

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
  // Keeps the frames that were used last, up to so many bytes, and at least the one that is wanted.
  explicit FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t keptBytes = std::uint64_t{1} << 30);
  ~FrameLoader();  // waits until what is being loaded has been loaded
  FrameLoader(const FrameLoader&) = delete;
  FrameLoader& operator=(const FrameLoader&) = delete;

  // Asks for this frame next, and then for at most 64 frames after it in the direction of `step` (1 or -1; 0: none), as
  // long as they fit into half of the bytes that are kept: the other half is for frames that were seen. What was asked
  // for before and is not begun is forgotten.
  void want(std::size_t frame, int step = 1);
  // The frame, or null while it is not loaded.
  std::shared_ptr<const ViewFrame> frame(std::size_t frame);
  // Waits until the frame is loaded.
  std::shared_ptr<const ViewFrame> wait(std::size_t frame);

  // Asks for the mesh of a scene, which is loaded after the frames that are asked for. One mesh is kept.
  void wantMesh(const SceneChoice& scene);
  // The mesh, or null while it is not loaded.
  std::shared_ptr<const ViewMesh> mesh(const SceneChoice& scene);
  // Waits until the mesh is loaded.
  std::shared_ptr<const ViewMesh> waitMesh(const SceneChoice& scene);

  // The name of what is asked for and not loaded yet, for people: "street-s1-lane-000012", "scene street". Empty where
  // there is nothing to load.
  std::string busy() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
