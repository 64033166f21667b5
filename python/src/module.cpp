#include <nanobind/nanobind.h>

#include <modsearch/problem/files.hpp>

#include "bindings.hpp"

NB_MODULE(_core, m) {
  namespace nb = nanobind;
  using namespace modsearch;

  nb::set_leak_warnings(false);  // objects that a traceback or a notebook still holds at exit are no leaks
  m.doc() = "The C++ core of modsearch, as the package modsearch uses it. Its names are those of modsearch.";
  m.attr("__version__") = MODSEARCH_VERSION;
  nb::exception<FileError>(m, "FileError", PyExc_ValueError).attr("__doc__") =
      "A file that cannot be used: one sentence with file, JSON pointer, value and limit.";
  nb::exception<EvaluationError>(m, "EvaluationError", PyExc_RuntimeError).attr("__doc__") =
      "A problem of your own could not evaluate a design: what its code raised, in words.";

  python::bind_library(m);
  python::bind_design(m);
  python::bind_evaluation(m);
  python::bind_arm(m);
  python::bind_problem(m);
  python::bind_solver(m);
  python::bind_files(m);
  python::bind_environment(m);
  python::bind_vector_environment(m);
}
