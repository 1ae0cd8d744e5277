#pragma once

// Loads frames and scenes on a separate thread, so that the window never blocks. All requests must come from one
// thread. Frame indices must be less than the source's number of keys; want() and wait() do not check this.

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "viewer/frames/frame_source.h"
#include "viewer/frames/view_mesh.h"

namespace scanmill {

class FrameLoader {
 public:
  // The cache holds the requested frame and, as far as `cacheBytes` bytes suffice, the frames nearest to this frame.
  explicit FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t cacheBytes = std::uint64_t{1} << 30);
  ~FrameLoader();                                  // waits until the current load is finished
  FrameLoader& operator=(FrameLoader&&) = delete;  // neither copied nor moved

  // Requests a frame, and after it at most 64 following frames in the direction of `step` (1 or -1; 0: none), as long
  // as these fit into half of `cacheBytes`; the other half is for frames that were shown before. Cancels earlier
  // requests that have not been started.
  void want(std::size_t frame, int step = 1);
  // Returns the frame; null if it is not loaded yet.
  std::shared_ptr<const ViewFrame> frame(std::size_t frame);
  // Waits until the frame is loaded and returns it; requests it unless it was requested last.
  std::shared_ptr<const ViewFrame> wait(std::size_t frame);

  // Requests the mesh of a scene, which is loaded after the requested frame. Only the mesh loaded last is cached.
  void wantMesh(const SceneChoice& scene);
  // Returns the mesh; null if it is not loaded yet.
  std::shared_ptr<const ViewMesh> mesh(const SceneChoice& scene);
  // Waits until the mesh is loaded and returns it; requests it unless it was requested last.
  std::shared_ptr<const ViewMesh> waitMesh(const SceneChoice& scene);

  // Returns the name of the requested frame or scene that is being loaded, such as "street-s1-lane-000012" or "scene
  // street"; empty if nothing is being loaded.
  std::string busy() const;

 private:
  // The caller of these functions holds `mutex_`.
  std::shared_ptr<const ViewFrame> find(std::size_t frame) const;
  bool meshShows(const SceneChoice& scene) const;
  bool meshMissing() const { return requestedMesh_ && !meshShows(*requestedMesh_); }
  std::optional<std::size_t> missingFrame() const;
  std::optional<std::size_t> nextAhead() const;
  void cache(std::size_t frame, ViewFrame loaded);
  // These functions run on the loading thread. `lock` holds `mutex_`, and releases it while data are loaded.
  void run();
  void loadFrame(std::size_t frame, std::unique_lock<std::mutex>& lock);
  void loadMesh(std::unique_lock<std::mutex>& lock);

  const std::shared_ptr<const FrameSource> source_;
  const std::uint64_t cacheBytes_;
  mutable std::mutex mutex_;           // guards all members below
  std::condition_variable requested_;  // signals new requests, or the end, to the loading thread
  std::condition_variable loaded_;     // signals that a frame or mesh has been loaded
  bool stopping_ = false;

  std::map<std::size_t, std::shared_ptr<const ViewFrame>> cached_;  // the keys are indices of frames
  std::optional<std::size_t> requestedFrame_;
  int step_ = 0;  // direction in which frames are read ahead; 0: no frames are read ahead

  std::optional<SceneChoice> requestedMesh_;
  std::shared_ptr<const ViewMesh> mesh_;  // the last loaded mesh, which shows `meshScene_`; null: none was loaded
  SceneChoice meshScene_;

  std::thread thread_;
};

}  // namespace scanmill
