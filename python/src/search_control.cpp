#include "search_control.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>

namespace modsearch::python {
namespace {

thread_local SearchControl* current_control = nullptr;

}  // namespace

SearchControl::SearchControl(nb::object problem, nb::object progress)
    : problem_{std::move(problem)}, progress_{std::move(progress)}, outer_{current_control} {
  current_control = this;
}

SearchControl::~SearchControl() { current_control = outer_; }

SearchControl* SearchControl::current() { return current_control; }

void SearchControl::fail(const nb::python_error& error) {
  if (!error_) error_ = std::make_exception_ptr(error);
  stop_.request_stop();
}

void SearchControl::observe(const Meter& meter) {
  constexpr auto kLook = std::chrono::milliseconds{50};  // nobody feels it, and taking the GIL costs nothing then
  const Clock::time_point now = Clock::now();
  if (now - looked_ < kLook) return;
  looked_ = now;
  const nb::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) fail(nb::python_error{});
  constexpr auto kShow = std::chrono::milliseconds{200};
  if (progress_.is_none() || error_ || now - shown_ < kShow) return;
  shown_ = now;
  show(meter);
}

void SearchControl::show(const Meter& meter) {
  const Progress spent = meter.progress();
  std::optional<double> score;
  if (meter.best()) score = meter.best()->evaluation.score;
  const bool achieved = meter.best() && meter.best()->evaluation.attempt.achieved;
  try {
    progress_(spent.evaluations, spent.seconds, score, achieved, spent.failed, meter.stage());
  } catch (const nb::python_error& error) {
    fail(error);
  }
}

bool ends_program(const nb::python_error& error) { return !error.matches(PyExc_Exception); }

std::string words_of(const nb::python_error& error) {
  std::string text = nb::cast<std::string>(error.type().attr("__name__"));
  try {
    const std::string what = nb::cast<std::string>(nb::str(error.value()));
    if (!what.empty()) text += ": " + what;
  } catch (const nb::python_error&) {
    text += " (which cannot be written as text)";  // its own __str__ raised
  }
  return text;
}

}  // namespace modsearch::python
