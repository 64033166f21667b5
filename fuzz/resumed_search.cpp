#include <array>
#include <memory>
#include <modsearch/baselines/annealing.hpp>
#include <modsearch/baselines/cma_es.hpp>
#include <modsearch/baselines/enumerate.hpp>
#include <modsearch/baselines/genetic_algorithm.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/tree_search.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <modsearch/solvers/search.hpp>
#include <span>

#include "reader.hpp"

namespace {

/// Goes on from the checkpoint for a step or a few evaluations, whichever is over first.
void resume(const modsearch::Archive& archive) {
  static const auto problem = modsearch::load_problem("seed/fixed");
  static const modsearch::CmaEs evolution;
  static const modsearch::Enumerate enumeration;
  static const modsearch::GeneticAlgorithm genetic{{.population = 6}};
  static const modsearch::RandomSearch random;
  static const modsearch::SimulatedAnnealing annealing;
  static const modsearch::TreeSearch tree;
  static const std::array<const modsearch::SteppedSolver*, 6> solvers{&evolution, &enumeration, &genetic,
                                                                      &random,    &annealing,   &tree};
  const std::string name = archive.text("solver");
  for (const modsearch::SteppedSolver* solver : solvers) {
    if (solver->name() != name) continue;
    const std::unique_ptr<modsearch::Search> search = solver->start(*problem, modsearch::Rng{0});
    modsearch::Meter meter{{.evaluations = 100'000, .seconds = 0.2}};
    search->restore(archive);
    meter.restore(archive, *problem);
    static_cast<void>(search->step(meter));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The archive without its checksum.
  std::string whole{fuzz::text(data, size)};
  const std::uint32_t checksum = modsearch::crc32c(std::as_bytes(std::span{whole}));
  whole.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  const auto file = fuzz::as_file(whole, "checkpoint");
  return fuzz::read<modsearch::FileError>([&] { resume(modsearch::Archive::load(file)); });
}
