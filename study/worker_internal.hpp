#pragma once

#include <sys/types.h>

#include <functional>
#include <modsearch/study/records.hpp>
#include <string>

namespace modsearch::detail {

/// A cell that is computed by a process of its own, so that whatever it does to itself (a crash, memory, a library that
/// is not made for threads) takes nothing else with it. The process is a copy of this one that tells its result through
/// a pipe; it does not outlive this one.
class Worker {
 public:
  /// Starts the process. `compute` gives the finished cell or throws. Throws std::runtime_error if there are no more
  /// processes or files to be had.
  Worker(const CellRecord& cell, const std::function<CellRecord()>& compute);
  Worker(Worker&& other) noexcept;
  Worker& operator=(Worker&& other) noexcept;
  /// Ends the process if it is still there.
  ~Worker();

  /// The pipe, to be polled.
  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] const CellRecord& cell() const { return cell_; }
  /// Takes what has come through the pipe. Whether that was all.
  [[nodiscard]] bool receive();
  /// After the last `receive`: the cell, done or failed.
  [[nodiscard]] CellRecord result();

 private:
  void swap(Worker& other) noexcept;

  CellRecord cell_;
  ::pid_t process_ = -1;
  int descriptor_ = -1;
  std::string text_;
};

}  // namespace modsearch::detail
