#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace modsearch::detail {

/// The order in which n things are visited so that the ways between them add up to least: exact by dynamic programming
/// over subsets (Held and Karp 1962, doi:10.1137/0110015) up to 12, beyond that the nearest next one, improved by
/// moving one thing at a time. `first` [n]: way from the start to each; `ways` [n x n]: from the end of one to the
/// beginning of another; `before`: pairs (a, b) of which a has to be visited earlier. The lexicographically first of
/// equals where it is exact. Throws std::invalid_argument if the pairs leave no order.
[[nodiscard]] std::vector<int> visiting_order(const Eigen::VectorXd& first, const Eigen::MatrixXd& ways,
                                              const std::vector<std::pair<int, int>>& before);

}  // namespace modsearch::detail
