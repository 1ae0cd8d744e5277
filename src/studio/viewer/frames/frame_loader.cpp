#include "viewer/frames/frame_loader.h"

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "scan/scan.h"

namespace scanmill {

namespace {

constexpr std::int64_t kMostAhead = 64;  // maximum number of frames that are read ahead, which play in several seconds

std::uint64_t frameBytes(const ViewFrame& frame) {
  const auto bytesOf = [](const auto& column) { return std::uint64_t{column.capacity()} * sizeof(column[0]); };
  std::uint64_t bytes = sizeof(ViewFrame);
  for (const ViewScan& s : frame.scans) {
    bytes += sizeof(ViewScan) + bytesOf(s.scan.position) + bytesOf(s.placed) + bytesOf(s.error);
    visitColumns(s.scan, [&](std::string_view, const auto& column) { bytes += bytesOf(column); });
  }
  return bytes;
}

ViewFrame loadFrame(const FrameSource& source, std::size_t frame) {
  try {
    return source.load(frame);
  } catch (const std::exception& e) {  // for example std::bad_alloc
    return {source.keys().at(frame), {}, {reasonOf(e)}};
  }
}

}  // namespace

struct FrameLoader::State {
  struct CachedFrame {
    std::shared_ptr<const ViewFrame> frame;
    std::uint64_t bytes = 0;
  };

  State(std::shared_ptr<const FrameSource> from, std::uint64_t limit) : source(std::move(from)), cacheBytes(limit) {}

  // The caller must hold `mutex` when calling the following functions, except run().

  void want(std::size_t frame, int newStep) {
    wanted = frame;
    step = newStep;
    work.notify_all();
  }

  std::shared_ptr<const ViewFrame> find(std::size_t number) const {
    const auto found = cached.find(number);
    return found == cached.end() ? nullptr : found->second.frame;
  }

  // True if the loaded mesh shows the scene at the time in `scene`. If nothing in the scene moves, the time is ignored.
  bool meshShows(const SceneChoice& scene) const {
    if (mesh == nullptr) return false;
    return meshScene == scene || (!mesh->moves && meshScene.file == scene.file && meshScene.seed == scene.seed);
  }
  bool meshMissing() const { return wantedMesh && !meshShows(*wantedMesh); }

  // Returns the next frame to read ahead in the direction of `step` that is not cached; nothing if there is none. The
  // requested frame and those that are read ahead, plus one frame of the largest size, may fill half of the cache. The
  // other half is for frames that were shown before.
  std::optional<std::size_t> nextAhead() const {
    if (!wanted || step == 0) return std::nullopt;
    std::uint64_t largest = 0, needed = 0;
    for (std::int64_t i = 0; i <= kMostAhead; ++i) {
      const std::int64_t at = static_cast<std::int64_t>(*wanted) + i * step;
      if (at < 0 || at >= static_cast<std::int64_t>(source->keys().size())) break;
      const auto number = static_cast<std::size_t>(at);
      const auto found = cached.find(number);
      if (found == cached.end()) return needed + largest <= cacheBytes / 2 ? std::optional(number) : std::nullopt;
      needed += found->second.bytes;
      largest = std::max(largest, found->second.bytes);
    }
    return std::nullopt;
  }

  std::optional<std::size_t> missingFrame() const { return wanted && !find(*wanted) ? wanted : std::nullopt; }

  // Caches the frame, and removes the frames that are farthest from the requested one until all fit. If the frame
  // itself is one of them, no more frames are read ahead.
  void cache(std::size_t number, ViewFrame frame) {
    const std::uint64_t bytes = frameBytes(frame);
    cached[number] = {std::make_shared<const ViewFrame>(std::move(frame)), bytes};
    const auto distance = [&](const auto& entry) {
      return std::abs(static_cast<std::int64_t>(entry.first) - static_cast<std::int64_t>(*wanted));
    };
    std::uint64_t cachedBytes = 0;
    for (const auto& entry : cached) cachedBytes += entry.second.bytes;
    while (cachedBytes > cacheBytes && cached.size() > 1) {
      const auto farthest = std::ranges::max_element(cached, {}, distance);
      cachedBytes -= farthest->second.bytes;
      cached.erase(farthest);
    }
    if (!cached.contains(number)) step = 0;
  }

  // The function of the loading thread: loads requested frames first, then the mesh, then reads frames ahead.
  void run() {
    std::unique_lock lock(mutex);
    while (!stopping) {
      auto number = missingFrame();
      const bool loadsMesh = !number && meshMissing();
      if (!number && !loadsMesh) number = nextAhead();
      if (number) {
        lock.unlock();
        ViewFrame frame = loadFrame(*source, *number);
        lock.lock();
        cache(*number, std::move(frame));
        done.notify_all();
      } else if (loadsMesh) {
        const SceneChoice scene = *wantedMesh;
        lock.unlock();
        auto made = std::make_shared<const ViewMesh>(loadViewMesh(scene.file, scene.seed, scene.time, scene.ontology));
        lock.lock();
        mesh = std::move(made);
        meshScene = scene;
        done.notify_all();
      } else {
        work.wait(lock);
      }
    }
  }

  const std::shared_ptr<const FrameSource> source;
  const std::uint64_t cacheBytes;
  mutable std::mutex mutex;
  std::condition_variable work;
  std::condition_variable done;
  bool stopping = false;

  std::map<std::size_t, CachedFrame> cached;
  std::optional<std::size_t> wanted;
  int step = 0;  // direction in which frames are read ahead; 0: none are

  std::optional<SceneChoice> wantedMesh;
  std::shared_ptr<const ViewMesh> mesh;
  SceneChoice meshScene;

  std::thread thread;
};

FrameLoader::FrameLoader(std::shared_ptr<const FrameSource> source, std::uint64_t cacheBytes)
    : state_(std::make_unique<State>(std::move(source), cacheBytes)) {
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

FrameLoader::~FrameLoader() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->work.notify_all();
  state_->thread.join();
}

void FrameLoader::want(std::size_t frame, int step) {
  const std::lock_guard lock(state_->mutex);
  state_->want(frame, step);
}

std::shared_ptr<const ViewFrame> FrameLoader::frame(std::size_t frame) {
  const std::lock_guard lock(state_->mutex);
  return state_->find(frame);
}

std::shared_ptr<const ViewFrame> FrameLoader::wait(std::size_t frame) {
  State& s = *state_;
  std::unique_lock lock(s.mutex);
  if (s.wanted != frame) s.want(frame, 0);
  s.done.wait(lock, [&] { return s.find(frame) != nullptr; });
  return s.find(frame);
}

void FrameLoader::wantMesh(const SceneChoice& scene) {
  const std::lock_guard lock(state_->mutex);
  state_->wantedMesh = scene;
  state_->work.notify_all();
}

std::shared_ptr<const ViewMesh> FrameLoader::mesh(const SceneChoice& scene) {
  const std::lock_guard lock(state_->mutex);
  return state_->meshShows(scene) ? state_->mesh : nullptr;
}

std::shared_ptr<const ViewMesh> FrameLoader::waitMesh(const SceneChoice& scene) {
  wantMesh(scene);
  State& s = *state_;
  std::unique_lock lock(s.mutex);
  s.done.wait(lock, [&] { return s.meshShows(scene); });
  return s.mesh;
}

std::string FrameLoader::busy() const {
  const std::lock_guard lock(state_->mutex);
  if (const auto number = state_->missingFrame()) return state_->source->keys()[*number];
  if (state_->meshMissing()) return "scene " + state_->wantedMesh->file.stem().string();
  return {};
}

}  // namespace scanmill
