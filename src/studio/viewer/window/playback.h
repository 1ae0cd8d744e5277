#pragma once

// Playback decides which frame is shown: the frame that the user requested, or the next one while frames are played. It
// knows neither a canvas nor a clock: callers pass the time, in seconds of one clock.

#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "viewer/frames/frame_loader.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

class Playback {
 public:
  // Requests the frame that `sample` names (see findFrame()). If `sample` is empty, no frame is chosen: the middle one
  // is requested and, if it cannot be read, the others in their order. Throws InputError if the sample does not exist.
  Playback(std::shared_ptr<const FrameSource> source, std::unique_ptr<FrameLoader> loader, const std::string& sample);

  // Requests a frame, or the last one if there are fewer frames, and afterwards its neighbours in the direction of
  // `step` (1, -1, or 0: none).
  void goTo(std::size_t frame, int step);
  // Requests the frame `count` frames after the requested one, or before it if `count` is negative, at most the last or
  // the first frame. False if that frame is requested already.
  bool stepBy(std::ptrdiff_t count);

  // Returns the requested frame if it is loaded and is not the current one, and makes it the current one; else null.
  // take() returns at once, wait() when the frame is loaded.
  std::shared_ptr<const ViewFrame> take(double now);
  std::shared_ptr<const ViewFrame> wait(double now);

  // Starts playing at the current frame, or at the first one if the current frame is the last; or stops.
  void togglePlaying(double now);
  void stop() { playing_ = false; }
  // Makes playing faster (1) or slower (-1).
  void changeSpeed(int step);
  // Requests the next frame if it is due. True if playing has ended, a frame was requested or busy() has changed.
  bool tick(double now);
  // Loads the frames after the current one in advance from now on.
  void readAhead();

  std::size_t count() const { return source_->keys().size(); }
  std::size_t requested() const { return requested_; }
  std::optional<std::size_t> current() const { return current_; }  // none: no frame has been loaded yet
  bool settled() const { return current_ == requested_; }
  bool playing() const { return playing_; }
  // Returns the playing speed for the user: "2x", "as fast as it loads".
  std::string speedText() const;
  // Returns the name of what is being loaded, for the user; empty: nothing.
  const std::string& busy() const { return busy_; }
  void clearBusy() { busy_.clear(); }
  // Returns the indices of the frames that are known to be unreadable, ascending.
  std::vector<std::size_t> damaged() const;
  // Returns why the current frame is not the one that was requested first; empty if it is.
  const std::string& substituted() const { return substituted_; }

  // The loader also loads scenes.
  FrameLoader& loader() { return *loader_; }

 private:
  void request(std::size_t frame, int step);
  bool accept(const std::shared_ptr<const ViewFrame>& loaded, double now);
  void requestNextReadable();
  double frameSeconds() const;

  std::shared_ptr<const FrameSource> source_;
  std::unique_ptr<FrameLoader> loader_;
  std::size_t requested_ = 0;
  std::optional<std::size_t> current_;
  std::optional<double> currentTime_;  // s since the start of its sequence; none: the frame has no scan
  double shownAt_ = 0;                 // s, when the current frame was taken or playing began
  double recordedSeconds_ = 0;         // time between the last two frames, if they are consecutive
  bool playing_ = false;
  std::size_t speed_;  // index into the factors of the speed
  bool readsAhead_ = false;
  bool seeking_ = false;                // the user chose no frame: the first readable one is searched
  std::size_t sought_ = 0;              // the frame with which the search began
  std::size_t nextTried_ = 0;           // the next frame that the search requests
  std::set<std::size_t> unreadable_{};  // frames that could not be loaded
  std::string busy_, substituted_;
};

}  // namespace scanmill
