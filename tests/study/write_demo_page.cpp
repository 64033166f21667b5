// Writes the demo page to the file named first; with a second argument, that many samples of its path.
#include <fstream>
#include <iostream>
#include <string>

#include "study/demo_page.hpp"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: write_demo_page FILE [SAMPLES]\n";
    return 2;
  }
  std::ofstream(argv[1]) << modsearch::write_page(modsearch::testing::demo_page(argc > 2 ? std::stoi(argv[2]) : 60));
  return 0;
}
