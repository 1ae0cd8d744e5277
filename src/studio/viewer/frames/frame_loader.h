#pragma once

// Loads frames and scenes on a separate thread, so that the window never blocks. One thread makes the requests.
// Indices of frames are less than the source's number of keys; want() and wait() do not check this.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"

namespace scanmill {

class FrameLoader {
 public:
  // Caches the frames about the one that was requested last, up to `cacheBytes` bytes; that one is always cached.
  explicit FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t cacheBytes = std::uint64_t{1} << 30);
  ~FrameLoader();  // waits until the current load is finished
  FrameLoader(const FrameLoader&) = delete;
  FrameLoader& operator=(const FrameLoader&) = delete;

  // Requests a frame, and after it at most 64 following frames in the direction of `step` (1 or -1; 0: none), as long
  // as these fit into half of `cacheBytes`; the other half is for frames that were shown before. Cancels earlier
  // requests that have not been started.
  void want(std::size_t frame, int step = 1);
  // Returns the frame; null if it is not loaded yet.
  std::shared_ptr<const ViewFrame> frame(std::size_t frame);
  // Waits until the frame is loaded and returns it; requests it unless it was requested last.
  std::shared_ptr<const ViewFrame> wait(std::size_t frame);

  // Requests the mesh of a scene. It is loaded after the requested frames. Only one mesh is cached.
  void wantMesh(const SceneChoice& scene);
  // Returns the mesh; null if it is not loaded yet.
  std::shared_ptr<const ViewMesh> mesh(const SceneChoice& scene);
  // Waits until the mesh is loaded and returns it; requests it unless it was requested last.
  std::shared_ptr<const ViewMesh> waitMesh(const SceneChoice& scene);

  // Returns the name of the requested frame or scene that is being loaded, such as "street-s1-lane-000012" or "scene
  // street"; empty if nothing is being loaded.
  std::string busy() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
