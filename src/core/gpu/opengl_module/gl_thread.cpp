#include "gpu/opengl_module/gl_thread.h"

namespace scanmill {

std::shared_ptr<GlThread> GlThread::shared() {
  static std::mutex mutex;
  static std::weak_ptr<GlThread> current;
  const std::scoped_lock lock(mutex);
  std::shared_ptr<GlThread> thread = current.lock();
  if (thread == nullptr) current = thread = std::make_shared<GlThread>();
  return thread;
}

GlThread::GlThread() : thread_([this] { serve(); }) {}

GlThread::~GlThread() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void GlThread::run(const std::function<void()>& work) {
  if (std::this_thread::get_id() == thread_.get_id()) return work();
  Job job{&work, nullptr};
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return job_ == nullptr; });
  job_ = &job;
  changed_.notify_all();
  changed_.wait(lock, [&] { return job.done; });
  if (job.failure) std::rethrow_exception(job.failure);
}

// Runs the jobs of run() until the destructor has set ended_.
void GlThread::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return job_ != nullptr || ended_; });
    if (job_ == nullptr) return;
    lock.unlock();
    try {
      (*job_->work)();
    } catch (...) {
      job_->failure = std::current_exception();
    }
    lock.lock();
    job_->done = true;
    job_ = nullptr;
    changed_.notify_all();
  }
}

}  // namespace scanmill
