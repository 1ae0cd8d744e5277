#pragma once

// The single thread on which a plug-in makes all calls of OpenGL and VTK.

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace scanmill {

// Runs functions one after the other on one thread. Two reasons: if a context is used on several threads in turn, Mesa
// 22.3's llvmpipe corrupts memory; and VTK's objects are not thread-safe.
class GlThread {
 public:
  // Returns the thread that all devices of a plug-in share. It ends when the last returned pointer is destroyed.
  static std::shared_ptr<GlThread> shared();

  GlThread();
  ~GlThread();
  GlThread& operator=(GlThread&&) = delete;  // neither copied nor moved

  // Calls `work` on this thread, waits until it is done, and rethrows its exception. If the caller is on this thread
  // already, calls `work` directly.
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
  std::thread thread_;  // declared last, since the thread uses the other members as soon as it starts
};

}  // namespace scanmill
