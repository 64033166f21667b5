#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace modsearch::python {

/// Threads that wait for work and share it: `run` calls a function for 0 .. n - 1, in contiguous parts, one per thread.
class WorkerPool {
 public:
  /// `threads`: the calling one included.
  explicit WorkerPool(int threads) : parts_{threads} {
    for (int part = 1; part < parts_; ++part) {
      workers_.emplace_back([this, part](const std::stop_token& stop) { work(stop, part); });
    }
  }
  ~WorkerPool() {
    for (std::jthread& worker : workers_) worker.request_stop();
    begun_.notify_all();
  }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Returns when all are done. Throws the exception of the first part that threw, after all parts have ended.
  void run(int n, const std::function<void(int)>& each) {
    {
      const std::lock_guard lock{mutex_};
      n_ = n;
      each_ = &each;
      open_ = parts_ - 1;
      errors_.assign(static_cast<std::size_t>(parts_), nullptr);
      ++round_;
    }
    begun_.notify_all();
    share(0);
    std::unique_lock lock{mutex_};
    done_.wait(lock, [&] { return open_ == 0; });
    for (const std::exception_ptr& error : errors_) {
      if (error) std::rethrow_exception(error);
    }
  }

 private:
  void share(int part) {
    try {
      for (int i = n_ * part / parts_; i < n_ * (part + 1) / parts_; ++i) (*each_)(i);
    } catch (...) {
      errors_[static_cast<std::size_t>(part)] = std::current_exception();
    }
  }

  void work(const std::stop_token& stop, int part) {
    std::uint64_t seen = 0;
    std::unique_lock lock{mutex_};
    while (begun_.wait(lock, stop, [&] { return round_ != seen; })) {
      seen = round_;
      lock.unlock();
      share(part);
      lock.lock();
      if (--open_ == 0) done_.notify_one();
    }
  }

  int parts_;
  int n_ = 0;
  const std::function<void(int)>* each_ = nullptr;
  std::vector<std::exception_ptr> errors_;
  int open_ = 0;
  std::uint64_t round_ = 0;
  std::mutex mutex_;
  std::condition_variable_any begun_;
  std::condition_variable done_;
  std::vector<std::jthread> workers_;  // last: they end before what they use
};

}  // namespace modsearch::python
