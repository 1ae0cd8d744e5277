#pragma once

// Loads frames and scenes on a separate thread, so that the window never waits for them.

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
  // Caches the last used frames, up to `keptBytes`, and always the wanted frame.
  explicit FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t keptBytes = std::uint64_t{1} << 30);
  ~FrameLoader();  // waits for the load in progress
  FrameLoader(const FrameLoader&) = delete;
  FrameLoader& operator=(const FrameLoader&) = delete;

  // Requests this frame next, and then at most 64 frames after it in the direction of `step` (1 or -1; 0: none), as
  // long as they fit into half of `keptBytes`: the other half is for frames that were seen. Earlier requests that have
  // not been started are dropped.
  void want(std::size_t frame, int step = 1);
  // Returns the frame, or null while it is not loaded.
  std::shared_ptr<const ViewFrame> frame(std::size_t frame);
  // Waits until the frame is loaded.
  std::shared_ptr<const ViewFrame> wait(std::size_t frame);

  // Requests the mesh of a scene, which is loaded after the requested frames. Only one mesh is cached.
  void wantMesh(const SceneChoice& scene);
  // Returns the mesh, or null while it is not loaded.
  std::shared_ptr<const ViewMesh> mesh(const SceneChoice& scene);
  // Waits until the mesh is loaded.
  std::shared_ptr<const ViewMesh> waitMesh(const SceneChoice& scene);

  // Returns the name of the requested frame or scene that is not loaded yet, for the user: "street-s1-lane-000012",
  // "scene street". Empty if there is nothing to load.
  std::string busy() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
