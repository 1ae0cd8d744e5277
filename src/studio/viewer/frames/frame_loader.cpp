#include "viewer/frames/frame_loader.h"

#include <cstdlib>

#include "scan/scan.h"

namespace scanmill {

namespace {

// Returns the approximate memory of a frame (bytes).
std::uint64_t frameBytes(const ViewFrame& frame) {
  const auto bytesOf = [](const auto& column) { return std::uint64_t{column.capacity()} * sizeof(column[0]); };
  std::uint64_t bytes = sizeof(ViewFrame);
  for (const ViewScan& s : frame.scans) {
    bytes += sizeof(ViewScan) + bytesOf(s.scan.position) + bytesOf(s.placed) + bytesOf(s.error);
    visitColumns(s.scan, [&](std::string_view, const auto& column) { bytes += bytesOf(column); });
  }
  return bytes;
}

}  // namespace

FrameLoader::FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t cacheBytes)
    : source_(std::move(source)), cacheBytes_(cacheBytes) {
  thread_ = std::thread([this] { run(); });
}

FrameLoader::~FrameLoader() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  source_->stop();
  requested_.notify_all();
  thread_.join();
}

void FrameLoader::want(std::size_t frame, int step) {
  const std::lock_guard lock(mutex_);
  requestedFrame_ = frame;
  step_ = step;
  requested_.notify_all();
}

std::shared_ptr<const ViewFrame> FrameLoader::frame(std::size_t frame) {
  const std::lock_guard lock(mutex_);
  return find(frame);
}

std::shared_ptr<const ViewFrame> FrameLoader::wait(std::size_t frame) {
  if (requestedFrame_ != frame) want(frame, 0);  // only want() changes `requestedFrame_`, on this thread
  std::unique_lock lock(mutex_);
  loaded_.wait(lock, [&] { return find(frame) != nullptr; });
  return find(frame);
}

void FrameLoader::wantMesh(const SceneChoice& scene) {
  const std::lock_guard lock(mutex_);
  requestedMesh_ = scene;
  requested_.notify_all();
}

std::shared_ptr<const ViewMesh> FrameLoader::mesh(const SceneChoice& scene) {
  const std::lock_guard lock(mutex_);
  return meshShows(scene) ? mesh_ : nullptr;
}

std::shared_ptr<const ViewMesh> FrameLoader::waitMesh(const SceneChoice& scene) {
  wantMesh(scene);
  std::unique_lock lock(mutex_);
  loaded_.wait(lock, [&] { return meshShows(scene); });
  return mesh_;
}

std::string FrameLoader::busy() const {
  const std::lock_guard lock(mutex_);
  if (const auto frame = missingFrame()) return source_->keys()[*frame];
  if (meshMissing()) return "scene " + requestedMesh_->file.stem().string();
  return {};
}

std::shared_ptr<const ViewFrame> FrameLoader::find(std::size_t frame) const {
  const auto found = cached_.find(frame);
  return found == cached_.end() ? nullptr : found->second;
}

// True if the loaded mesh shows the scene at the time in `scene`. If nothing in the scene moves, the time is ignored.
bool FrameLoader::meshShows(const SceneChoice& scene) const {
  if (mesh_ == nullptr) return false;
  return meshScene_ == scene || (!mesh_->moves && meshScene_.file == scene.file && meshScene_.seed == scene.seed);
}

// Returns the requested frame if it is not cached; otherwise nothing.
std::optional<std::size_t> FrameLoader::missingFrame() const {
  return requestedFrame_ && !find(*requestedFrame_) ? requestedFrame_ : std::nullopt;
}

// Returns the next frame to read ahead in the direction of `step_` that is not cached; nothing if there is none. The
// requested frame, the frames read ahead and one more frame of the largest size may fill half of the cache. The other
// half is for frames that were shown before.
std::optional<std::size_t> FrameLoader::nextAhead() const {
  constexpr std::int64_t kMostAhead = 64;  // number of frames that are read ahead, which play in several seconds
  if (!requestedFrame_ || step_ == 0) return std::nullopt;
  std::uint64_t largestBytes = 0, cachedBytes = 0;  // sizes (bytes) of the cached frames ahead
  for (std::int64_t i = 0; i <= kMostAhead; ++i) {
    const std::int64_t index = static_cast<std::int64_t>(*requestedFrame_) + i * step_;
    if (index < 0 || index >= static_cast<std::int64_t>(source_->keys().size())) break;
    const auto frame = static_cast<std::size_t>(index);
    const auto found = cached_.find(frame);
    if (found == cached_.end()) {
      return cachedBytes + largestBytes <= cacheBytes_ / 2 ? std::optional(frame) : std::nullopt;
    }
    cachedBytes += frameBytes(*found->second);
    largestBytes = std::max(largestBytes, frameBytes(*found->second));
  }
  return std::nullopt;
}

// Caches the frame, then removes the frames farthest from the requested frame until the rest fit into `cacheBytes_`. If
// the new frame is removed, stops reading ahead.
void FrameLoader::cache(std::size_t frame, ViewFrame loaded) {
  cached_[frame] = std::make_shared<const ViewFrame>(std::move(loaded));
  const auto distance = [&](const auto& entry) {
    return std::abs(static_cast<std::int64_t>(entry.first) - static_cast<std::int64_t>(*requestedFrame_));
  };
  std::uint64_t cachedBytes = 0;
  for (const auto& entry : cached_) cachedBytes += frameBytes(*entry.second);
  while (cachedBytes > cacheBytes_ && cached_.size() > 1) {
    const auto farthest = std::ranges::max_element(cached_, {}, distance);
    cachedBytes -= frameBytes(*farthest->second);
    cached_.erase(farthest);
  }
  if (!cached_.contains(frame)) step_ = 0;
}

// Loads the requested frame first, then the requested mesh, then reads frames ahead; waits if there is nothing to load.
void FrameLoader::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (const auto frame = missingFrame()) {
      loadFrame(*frame, lock);
    } else if (meshMissing()) {
      loadMesh(lock);
    } else if (const auto ahead = nextAhead()) {
      loadFrame(*ahead, lock);
    } else {
      requested_.wait(lock);
    }
  }
}

void FrameLoader::loadFrame(std::size_t frame, std::unique_lock<std::mutex>& lock) {
  lock.unlock();
  ViewFrame loaded;
  try {
    loaded = source_->load(frame);
  } catch (const std::exception& e) {  // for example std::bad_alloc
    loaded = {.key = source_->keys().at(frame), .scans = {}, .problems = {reasonOf(e)}};
  }
  lock.lock();
  cache(frame, std::move(loaded));
  loaded_.notify_all();
}

void FrameLoader::loadMesh(std::unique_lock<std::mutex>& lock) {
  const SceneChoice scene = *requestedMesh_;
  lock.unlock();
  auto loaded = std::make_shared<const ViewMesh>(loadViewMesh(scene));
  lock.lock();
  mesh_ = std::move(loaded);
  meshScene_ = scene;
  loaded_.notify_all();
}

}  // namespace scanmill
