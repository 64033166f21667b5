#pragma once

#include <Eigen/Core>
#include <functional>
#include <modsearch/problem/rng.hpp>
#include <span>
#include <string>
#include <vector>

namespace modsearch {

class Archive;

/// A point of a mixed space: real numbers and choices among categories.
struct MixedPoint {
  Eigen::VectorXd x;            ///< [n_x]
  std::vector<int> categories;  ///< [n_c], the i-th in [0, n_categories(i))
};

/// Where a search in a mixed space begins.
struct CatCmaStart {
  Eigen::VectorXd mean;         ///< of the real variables [n_x]
  double sigma = 1.0;           ///< first standard deviation of each of them
  std::vector<int> categories{};  ///< how many each categorical variable has [n_c], at least 1; uniform at first
  int population = 0;           ///< points per generation; 0: 4 + 3 ln(n_x + n_c), Hansen 2016, table 1
};

/// A search distribution over a mixed space: a normal distribution N(m, sigma^2 C) for the real variables times a
/// categorical one per choice, both moved along the natural gradient towards what ranks well, and kept from collapsing
/// by a least probability of each category (the margin).
///
/// Source: Hamano, Saito, Nomura, Uchida and Shirakawa 2024, "CatCMA: Stochastic Optimization for Mixed-Category
/// Problems", GECCO, arXiv:2405.09962: CMA-ES with active covariance update (Hansen 2016, "The CMA Evolution Strategy:
/// A Tutorial", arXiv:1604.00772) and, for the categories, the adaptive learning rate of ASNG (Akimoto, Shirakawa,
/// Yoshinari, Uchida, Saito and Nishida 2019, ICML). CatCMA with margin (Hamano et al. 2025, arXiv:2504.07884) adds
/// integers to it, which designs do not have; without them it is this.
///
/// Nothing here knows bounds or values: it is told points in order of merit, so that any order will do.
class CatCma {
 public:
  /// Which categories the next variable may take, given those of the variables before it. None: what follows does not
  /// matter.
  using Mask = std::function<std::vector<int>(std::span<const int> chosen)>;

  /// Throws std::invalid_argument for an empty space, a sigma that is not positive, or a variable without categories.
  explicit CatCma(const CatCmaStart& start);

  [[nodiscard]] int population() const { return static_cast<int>(weights_.size()); }
  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }
  /// Largest standard deviation along any axis.
  [[nodiscard]] double spread() const { return sigma_ * axes_.maxCoeff(); }
  /// Probability of each category of variable `i`.
  [[nodiscard]] const Eigen::VectorXd& probabilities(int i) const { return q_[static_cast<std::size_t>(i)]; }
  /// The covariance has degenerated: a condition of more than 1e14 (Hansen 2016, appendix B.3), or an infinite spread.
  [[nodiscard]] bool degenerate() const;

  [[nodiscard]] MixedPoint ask(Rng& rng, const Mask& mask = {}) const;
  /// Moves the distribution. `ranked`: population() points of this generation, the best first.
  /// Throws std::invalid_argument for another number.
  void tell(std::span<const MixedPoint> ranked);

  /// Everything but what the constructor was given. Restoring throws FileError for an archive of another space.
  void save(Archive& archive, const std::string& prefix) const;
  void restore(const Archive& archive, const std::string& prefix);

 private:
  void update_normal(std::span<const MixedPoint> ranked);
  void update_categorical(std::span<const MixedPoint> ranked);
  void decompose();

  // Letters as in Hansen 2016; alpha, delta and gamma as in Akimoto et al. 2019.
  Eigen::VectorXd weights_;  // w_i [population]; the negative ones are the active part
  int mu_ = 0;
  double mu_eff_ = 0.0;
  double c_1_ = 0.0, c_mu_ = 0.0, c_c_ = 0.0, c_sigma_ = 0.0, d_sigma_ = 0.0, chi_n_ = 0.0;
  int generation_ = 0;
  Eigen::VectorXd mean_;
  double sigma_ = 1.0;
  Eigen::MatrixXd C_;
  Eigen::VectorXd p_sigma_, p_c_;
  Eigen::MatrixXd B_;     // eigenvectors of C
  Eigen::VectorXd axes_;  // square roots of its eigenvalues

  std::vector<Eigen::VectorXd> q_;  // probabilities, per categorical variable
  double q_margin_ = 0.0;           // a category has at least this, divided by the number of others
  Eigen::VectorXd s_;               // accumulated direction of the natural gradient
  double gamma_ = 0.0;
  double Delta_ = 1.0;
};

}  // namespace modsearch
