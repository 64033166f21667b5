// Writes the report of a made-up study: write_demo_report FILE
#include <cstdlib>
#include <iostream>
#include <modsearch/study/report.hpp>

#include "study/synthetic_study.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_demo_report FILE\n";
    return EXIT_FAILURE;
  }
  modsearch::write_report(modsearch::testing::synthetic_study(), argv[1], {.views = false});
  return EXIT_SUCCESS;
}
