#pragma once

// Decides which frame is shown: the frame that the user requested, or the next frame while frames are played. Callers
// pass the current time `now` in seconds, always from the same clock.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "viewer/frames/frame_loader.h"

namespace scanmill {

class Playback {
 public:
  // Requests the frame that `sample` names, see FrameSource::find(). Throws InputError if the sample does not exist.
  Playback(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader, const std::string& sample);

  // Requests a frame (at most the last frame), then reads ahead in the direction of `step` (1 or -1; 0: no frames).
  void goTo(std::size_t frame, int step);
  // Requests the frame that is `count` frames after the requested frame, or before it if `count` is negative. Stops at
  // the first and last frame. Returns false if the request does not change.
  bool stepBy(std::ptrdiff_t count);

  // Makes the requested frame the current one and returns it; null if it is current already or not loaded yet.
  std::shared_ptr<const ViewFrame> take(double now);

  // Stops playing, or starts playing from the requested frame (if that is the last frame: from the first frame).
  void togglePlaying(double now);
  void stop() { playing_ = false; }
  // Requests the next frame if it is due. Returns true if playing has ended, a frame was requested or busy() changed.
  bool tick(double now);
  // Starts reading ahead the frames after the requested frame; only the first call has an effect.
  void readAhead();

  std::size_t count() const { return source_->keys().size(); }
  std::size_t requested() const { return requested_; }
  std::optional<std::size_t> current() const { return current_; }  // absent: no frame has been loaded
  bool isUpToDate() const { return current_ == requested_; }
  bool playing() const { return playing_; }
  // Returns the name of the frame or scene that is being loaded; empty if nothing is being loaded.
  const std::string& busy() const { return busy_; }
  void clearBusy() { busy_.clear(); }

  FrameLoader& loader() { return *loader_; }

 private:
  std::shared_ptr<const FrameSource> source_;
  std::unique_ptr<FrameLoader> loader_;
  std::size_t requested_ = 0;
  std::optional<std::size_t> current_;
  std::optional<double> currentTime_;  // time of the current frame in its sequence (s); absent: the frame has no scan
  double shownAt_ = 0;                 // time at which the current frame was received or playing began (s)
  double recordedSeconds_ = 0;         // recorded time between the last two frames (s); 0: not consecutive frames
  bool playing_ = false;
  bool readsAhead_ = false;
  std::string busy_;
};

}  // namespace scanmill
