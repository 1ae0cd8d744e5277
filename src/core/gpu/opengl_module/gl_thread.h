#pragma once

// The thread on which a module makes its calls of OpenGL and VTK.

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace scanmill {

// Runs pieces of work one after the other. A context that wanders from thread to thread, made current and released each
// time, corrupts memory in Mesa 22.3's llvmpipe; and VTK's own objects are not made for several threads.
class GlThread {
 public:
  // The one thread for all devices of a module. It ends with the last of them.
  static std::shared_ptr<GlThread> shared();

  GlThread();
  ~GlThread();
  GlThread(const GlThread&) = delete;
  GlThread& operator=(const GlThread&) = delete;

  // Waits until the work is done, and throws what it throws. Called by work on this thread, it is done at once.
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
  std::thread thread_;  // last: it starts when all else is there
};

}  // namespace scanmill
