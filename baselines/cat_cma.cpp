#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <modsearch/baselines/cat_cma.hpp>
#include <modsearch/solvers/archive.hpp>
#include <stdexcept>

namespace modsearch {
namespace {

// One of `allowed`, with probability proportional to q.
int drawn(const Eigen::VectorXd& q, std::span<const int> allowed, Rng& rng) {
  double sum = 0.0;
  for (const int k : allowed) sum += q[k];
  double left = rng.uniform() * sum;
  for (const int k : allowed) {
    left -= q[k];
    if (left < 0.0) return k;
  }
  return allowed.back();
}

std::span<const double> numbers(const Eigen::MatrixXd& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

}  // namespace

CatCma::CatCma(const CatCmaStart& start) : mean_{start.mean}, sigma_{start.sigma} {
  const auto n = static_cast<double>(mean_.size());
  const double n_all = n + static_cast<double>(start.categories.size());
  if (n_all < 1.0) throw std::invalid_argument("CatCma: a space without variables");
  if (!(sigma_ > 0.0)) throw std::invalid_argument(fmt::format("CatCma: sigma is {}, not positive", sigma_));

  // Hansen 2016, table 1.
  const int population = start.population > 0 ? start.population : 4 + static_cast<int>(3.0 * std::log(n_all));
  if (population < 2) throw std::invalid_argument(fmt::format("CatCma: population is {}, not at least 2", population));
  mu_ = population / 2;
  weights_.resize(population);
  for (int i = 0; i < population; ++i) weights_[i] = std::log((population + 1) / 2.0) - std::log(i + 1.0);
  const auto effective = [](const auto& w) { return w.sum() * w.sum() / w.squaredNorm(); };
  mu_eff_ = effective(weights_.head(mu_));
  const double mu_eff_minus = effective(weights_.tail(population - mu_));
  c_1_ = 2.0 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(1.0 - c_1_, 2.0 * (mu_eff_ - 2.0 + 1.0 / mu_eff_) / ((n + 2.0) * (n + 2.0) + mu_eff_));
  double alpha = 1.0 + 2.0 * mu_eff_minus / (mu_eff_ + 2.0);
  if (n > 0.0 && c_mu_ > 0.0) {
    alpha = std::min({alpha, 1.0 + c_1_ / c_mu_, std::max(0.0, 1.0 - c_1_ - c_mu_) / (n * c_mu_)});
  }
  const double positive = weights_.cwiseMax(0.0).sum();
  const double negative = -weights_.cwiseMin(0.0).sum();
  for (double& w : weights_) w *= w >= 0.0 ? 1.0 / positive : alpha / negative;
  c_c_ = n > 0.0 ? (4.0 + mu_eff_ / n) / (n + 4.0 + 2.0 * mu_eff_ / n) : 1.0;
  c_sigma_ = (mu_eff_ + 2.0) / (n + mu_eff_ + 5.0);
  d_sigma_ = 1.0 + 2.0 * std::max(0.0, std::sqrt((mu_eff_ - 1.0) / (n + 1.0)) - 1.0) + c_sigma_;
  chi_n_ = n > 0.0 ? std::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)) : 1.0;
  C_ = Eigen::MatrixXd::Identity(mean_.size(), mean_.size());
  p_sigma_ = p_c_ = Eigen::VectorXd::Zero(mean_.size());
  decompose();

  int free_probabilities = 0;
  for (const int k : start.categories) {
    if (k < 1) throw std::invalid_argument(fmt::format("CatCma: a variable of {} categories, not at least 1", k));
    q_.push_back(Eigen::VectorXd::Constant(k, 1.0 / k));
    free_probabilities += k - 1;
  }
  s_ = Eigen::VectorXd::Zero(free_probabilities);
  // CatCMA, section 4.2: all n_c choices are at their best category at once with a probability of at least 0.73.
  if (!q_.empty()) q_margin_ = 1.0 - std::pow(0.73, 1.0 / static_cast<double>(q_.size()));
}

bool CatCma::degenerate() const {
  if (mean_.size() == 0) return false;
  const double largest = axes_.maxCoeff();
  return !std::isfinite(sigma_ * largest) || !mean_.allFinite() || largest > 1e7 * axes_.minCoeff();
}

void CatCma::decompose() {
  if (mean_.size() == 0) {
    axes_ = Eigen::VectorXd::Zero(1);
    return;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{C_};
  B_ = eigen.eigenvectors();
  axes_ = eigen.eigenvalues().cwiseMax(1e-300).cwiseSqrt();
}

MixedPoint CatCma::ask(Rng& rng, const Mask& mask) const {
  MixedPoint point;
  if (mean_.size() > 0) {
    Eigen::VectorXd z(mean_.size());
    for (double& value : z) value = rng.normal();
    point.x = mean_ + sigma_ * (B_ * axes_.cwiseProduct(z));
  }
  for (const Eigen::VectorXd& q : q_) {
    std::vector<int> allowed;
    if (mask) allowed = mask(point.categories);
    if (allowed.empty()) {
      for (int k = 0; k < static_cast<int>(q.size()); ++k) allowed.push_back(k);
    }
    point.categories.push_back(drawn(q, allowed, rng));
  }
  return point;
}

void CatCma::tell(std::span<const MixedPoint> ranked) {
  if (static_cast<int>(ranked.size()) != population()) {
    throw std::invalid_argument(
        fmt::format("CatCma::tell: {} points, the population has {}", ranked.size(), population()));
  }
  ++generation_;
  if (mean_.size() > 0) update_normal(ranked);
  if (s_.size() > 0) update_categorical(ranked);
}

void CatCma::update_normal(std::span<const MixedPoint> ranked) {
  const auto n = static_cast<double>(mean_.size());
  Eigen::MatrixXd y(mean_.size(), population());
  for (int i = 0; i < population(); ++i) y.col(i) = (ranked[static_cast<std::size_t>(i)].x - mean_) / sigma_;
  const auto whitened = [&](const auto& v) -> Eigen::VectorXd {  // C^(-1/2) v, but for a rotation
    return (B_.transpose() * v).cwiseQuotient(axes_);
  };
  const Eigen::VectorXd y_w = y.leftCols(mu_) * weights_.head(mu_);
  mean_ += sigma_ * y_w;

  p_sigma_ = (1.0 - c_sigma_) * p_sigma_ + std::sqrt(c_sigma_ * (2.0 - c_sigma_) * mu_eff_) * (B_ * whitened(y_w));
  const double length = p_sigma_.norm();
  const double expected = std::sqrt(1.0 - std::pow(1.0 - c_sigma_, 2.0 * generation_));
  const double h_sigma = length / expected < (1.4 + 2.0 / (n + 1.0)) * chi_n_ ? 1.0 : 0.0;

  p_c_ = (1.0 - c_c_) * p_c_ + h_sigma * std::sqrt(c_c_ * (2.0 - c_c_) * mu_eff_) * y_w;
  Eigen::VectorXd w = weights_;
  for (int i = 0; i < population(); ++i) {
    if (w[i] < 0.0) w[i] *= n / std::max(whitened(y.col(i)).squaredNorm(), 1e-300);
  }
  const double lost = (1.0 - h_sigma) * c_c_ * (2.0 - c_c_);
  C_ = (1.0 + c_1_ * lost - c_1_ - c_mu_ * weights_.sum()) * C_ + c_1_ * p_c_ * p_c_.transpose() +
       c_mu_ * y * w.asDiagonal() * y.transpose();
  sigma_ *= std::exp(c_sigma_ / d_sigma_ * (length / chi_n_ - 1.0));
  decompose();
}

void CatCma::update_categorical(std::span<const MixedPoint> ranked) {
  // Natural gradient, and its length in the metric of the Fisher information (Akimoto et al. 2019, appendix B).
  std::vector<Eigen::VectorXd> gradient;
  Eigen::VectorXd scaled(s_.size());
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const Eigen::VectorXd& q = q_[i];
    Eigen::VectorXd g = -q;  // the positive weights sum to 1
    for (int j = 0; j < mu_; ++j) g[ranked[static_cast<std::size_t>(j)].categories[i]] += weights_[j];
    const Eigen::Index free = q.size() - 1;
    const double q_last = q[free];
    const Eigen::VectorXd root = q.head(free).cwiseSqrt();
    scaled.segment(at, free) =
        g.head(free).cwiseQuotient(root) + root * (g.head(free).sum() / (q_last + std::sqrt(q_last)));
    at += free;
    gradient.push_back(std::move(g));
  }
  const double length = scaled.norm();
  if (!(length > 0.0)) return;
  const double delta = 1.0 / Delta_;
  for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += delta / length * gradient[i];

  constexpr double kAlpha = 1.5;  // signal-to-noise ratio aimed at
  const double beta = delta / std::sqrt(static_cast<double>(s_.size()));
  s_ = (1.0 - beta) * s_ + std::sqrt(beta * (2.0 - beta)) * scaled / length;
  gamma_ = (1.0 - beta) * (1.0 - beta) * gamma_ + beta * (2.0 - beta);
  Delta_ *= std::exp(beta * (gamma_ - s_.squaredNorm() / kAlpha));

  for (Eigen::VectorXd& q : q_) {
    if (q.size() < 2) continue;
    const double least = q_margin_ / static_cast<double>(q.size() - 1);
    q = q.cwiseMax(least);
    const Eigen::VectorXd above = q.array() - least;
    q += (1.0 - q.sum()) / above.sum() * above;  // what is too much comes off those above the margin
    q /= q.sum();
  }
}

void CatCma::save(Archive& archive, const std::string& prefix) const {
  archive.put_integer(prefix + "/generation", generation_);
  archive.put(prefix + "/scalars", std::array<double, 3>{sigma_, gamma_, Delta_});
  archive.put(prefix + "/mean", numbers(mean_));
  archive.put(prefix + "/C", numbers(C_));
  archive.put(prefix + "/p_sigma", numbers(p_sigma_));
  archive.put(prefix + "/p_c", numbers(p_c_));
  archive.put(prefix + "/s", numbers(s_));
  std::vector<double> q;
  for (const Eigen::VectorXd& one : q_) q.insert(q.end(), one.begin(), one.end());
  archive.put(prefix + "/q", std::span<const double>{q});
}

void CatCma::restore(const Archive& archive, const std::string& prefix) {
  const auto read = [&](const std::string& name, auto& matrix) {
    const std::vector<double> values = archive.numbers(prefix + name);
    if (static_cast<Eigen::Index>(values.size()) != matrix.size()) {
      archive.fail(prefix + name, fmt::format("holds {} numbers (limit: {})", values.size(), matrix.size()));
    }
    std::copy(values.begin(), values.end(), matrix.data());
  };
  generation_ = static_cast<int>(archive.integer(prefix + "/generation"));
  Eigen::Vector3d scalars;
  read("/scalars", scalars);
  sigma_ = scalars[0];
  gamma_ = scalars[1];
  Delta_ = scalars[2];
  read("/mean", mean_);
  read("/C", C_);
  read("/p_sigma", p_sigma_);
  read("/p_c", p_c_);
  read("/s", s_);
  Eigen::Index total = 0;
  for (const Eigen::VectorXd& one : q_) total += one.size();
  Eigen::VectorXd q(total);
  read("/q", q);
  Eigen::Index at = 0;
  for (Eigen::VectorXd& one : q_) {
    one = q.segment(at, one.size());
    at += one.size();
  }
  decompose();
}

}  // namespace modsearch
