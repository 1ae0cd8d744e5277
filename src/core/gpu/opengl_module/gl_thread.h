#pragma once

// The thread on which a plug-in calls OpenGL and VTK.

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace scanmill {

// Runs pieces of work one after the other. A context that moves from thread to thread, made current and released each
// time, corrupts memory in Mesa 22.3's llvmpipe; and VTK's own objects are not thread-safe.
class GlThread {
 public:
  // Returns the one thread for all devices of a plug-in. It ends with the last of them.
  static std::shared_ptr<GlThread> shared();

  GlThread();
  ~GlThread();
  GlThread(const GlThread&) = delete;
  GlThread& operator=(const GlThread&) = delete;

  // Runs the work on this thread, waits until it is done, and throws what it throws. Work that is already on this
  // thread runs at once.
  void run(const std::function<void()>& work);

 private:
  struct Job {
    const std::function<void()>* work;
    std::exception_ptr failure;
    bool done = false;
  };

  void serve();

  std::mutex mutex_;
  std::condition_variable changed_;
  Job* job_ = nullptr;
  bool ended_ = false;
  std::thread thread_;  // last: it starts when all other members exist
};

}  // namespace scanmill
