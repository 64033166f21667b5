#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <exception>
#include <modsearch/solvers/meter.hpp>
#include <stop_token>

namespace modsearch::python {

namespace nb = nanobind;

/// What goes on between a search and the interpreter that waits for it: Ctrl-C, the progress that somebody wants to
/// see, and exceptions of Python that have to wait until the search has ended. While it lives it is the one of this
/// thread.
class SearchControl {
 public:
  /// `problem`: as Python knows it. `progress`: None, or called with (evaluations, seconds, score or None, achieved,
  /// failed, stage) at most five times a second.
  SearchControl(nb::object problem, nb::object progress);
  ~SearchControl();
  SearchControl(const SearchControl&) = delete;
  SearchControl& operator=(const SearchControl&) = delete;

  [[nodiscard]] std::stop_token token() const { return stop_.get_token(); }
  [[nodiscard]] const nb::object& problem() const { return problem_; }
  /// Looks for signals at most every 50 ms, and shows progress. For Meter::Observer, with or without the GIL.
  void observe(const Meter& meter);
  /// Ends the search as soon as it looks; the exception is raised when it has ended. The first one counts.
  void fail(const nb::python_error& error);
  /// What was raised meanwhile; null: nothing.
  [[nodiscard]] std::exception_ptr error() const { return error_; }

  /// The one of this thread, or null.
  [[nodiscard]] static SearchControl* current();

 private:
  using Clock = std::chrono::steady_clock;

  void show(const Meter& meter);

  nb::object problem_;
  nb::object progress_;
  std::stop_source stop_;
  std::exception_ptr error_;
  Clock::time_point looked_ = Clock::now();
  Clock::time_point shown_ = Clock::now();
  SearchControl* outer_;
};

/// Whether `error` is one of those that end a program (KeyboardInterrupt, SystemExit) and are no fault of a design.
[[nodiscard]] bool ends_program(const nb::python_error& error);
/// "ValueError: what it said", on one line. Needs the GIL.
[[nodiscard]] std::string words_of(const nb::python_error& error);

}  // namespace modsearch::python
