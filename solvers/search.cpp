#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <modsearch/solvers/search.hpp>
#include <stdexcept>
#include <vector>

namespace modsearch {

SearchEnd run(Search& search, Meter& meter) {
  while (true) {
    if (std::optional<SearchEnd> end = search.step(meter)) return *std::move(end);
  }
}

SearchEnd SteppedSolver::do_solve(const DesignProblem& problem, Meter& meter, Rng rng) const {
  return run(*start(problem, rng), meter);
}

void put(Archive& archive, const std::string& name, const Rng& rng) {
  const std::array<std::uint64_t, 2> state = rng.state();
  archive.put(name, std::span<const std::uint64_t>{state});
}

Rng restored_rng(const Archive& archive, const std::string& name) {
  const std::vector<std::uint64_t> state = archive.unsigned_integers(name);
  if (state.size() != 2) archive.fail(name, fmt::format("holds {} numbers (limit: 2)", state.size()));
  return Rng{std::array<std::uint64_t, 2>{state[0], state[1]}};
}

void put(Archive& archive, const std::string& name, const Eigen::MatrixXd& matrix) {
  archive.put_integer(name + "/rows", matrix.rows());
  archive.put(name + "/values", std::span<const double>{matrix.data(), static_cast<std::size_t>(matrix.size())});
}

Eigen::MatrixXd restored_matrix(const Archive& archive, const std::string& name) {
  const std::int64_t rows = archive.integer(name + "/rows");
  const std::vector<double> values = archive.numbers(name + "/values");
  const auto size = static_cast<std::int64_t>(values.size());
  if (rows < 0 || (rows == 0 ? size > 0 : size % rows != 0)) {
    archive.fail(name + "/rows", fmt::format("is {}, which {} values do not fill", rows, size));
  }
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, rows == 0 ? 0 : size / rows);
}

void put(Archive& archive, const std::string& name, std::span<const Design> designs) {
  std::vector<std::int64_t> lengths;
  std::vector<std::int64_t> types;
  std::vector<double> parameters;
  for (const Design& design : designs) {
    lengths.push_back(static_cast<std::int64_t>(design.modules.size()));
    for (const Placement& placement : design.modules) {
      types.push_back(placement.type);
      parameters.insert(parameters.end(), placement.parameters.begin(), placement.parameters.end());
    }
  }
  archive.put(name + "/lengths", std::span<const std::int64_t>{lengths});
  archive.put(name + "/types", std::span<const std::int64_t>{types});
  archive.put(name + "/parameters", std::span<const double>{parameters});
}

std::vector<Design> restored_designs(const Archive& archive, const std::string& name, const ModuleLibrary& library) {
  const std::vector<std::int64_t> lengths = archive.integers(name + "/lengths");
  const std::vector<std::int64_t> types = archive.integers(name + "/types");
  const std::vector<double> parameters = archive.numbers(name + "/parameters");
  std::size_t next_type = 0;
  std::size_t next_parameter = 0;
  std::vector<Design> designs;
  for (const std::int64_t length : lengths) {
    Design design;
    for (std::int64_t i = 0; i < length; ++i) {
      if (next_type >= types.size()) archive.fail(name + "/types", "ends within a design");
      const std::int64_t k = types[next_type++];
      if (k < 0 || k >= library.n_types()) {
        archive.fail(name + "/types", fmt::format("holds type {} (limit: [0, {}))", k, library.n_types()));
      }
      const int n = library.type(static_cast<int>(k)).n_parameters();
      if (parameters.size() - next_parameter < static_cast<std::size_t>(n)) {
        archive.fail(name + "/parameters", "ends within a design");
      }
      Placement placement{static_cast<int>(k), Parameters(n)};
      for (int p = 0; p < n; ++p) placement.parameters[p] = parameters[next_parameter++];
      design.modules.push_back(std::move(placement));
    }
    try {
      check(library, design);
    } catch (const std::invalid_argument& error) {
      archive.fail(name, error.what());
    }
    designs.push_back(std::move(design));
  }
  return designs;
}

}  // namespace modsearch
