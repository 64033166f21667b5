#pragma once

#include <Eigen/Core>
#include <cmath>
#include <modsearch/problem/rng.hpp>
#include <modsearch/rl/mlp.hpp>
#include <vector>

namespace modsearch::reference {

struct Gradients {
  std::vector<Eigen::MatrixXd> w;
  std::vector<Eigen::VectorXd> b;
  Eigen::MatrixXd x;
};

// A multi-layer perceptron in double precision, as a textbook writes it: shares nothing with the fast one but the
// start.
struct DoubleNetwork {
  DoubleNetwork(const Network& network, const float* weights) : leak{static_cast<double>(network.shape().leak)} {
    for (int l = 0; l < static_cast<int>(network.layers().size()); ++l) {
      float* const from = const_cast<float*>(weights);
      w.push_back(Mlp::weights(network, from, l).cast<double>());
      b.push_back(Mlp::bias(network, from, l).cast<double>());
    }
  }
  explicit DoubleNetwork(const Mlp& mlp) : DoubleNetwork{Network{mlp.shape()}, mlp.parameters().data()} {}

  Eigen::MatrixXd forward(const Eigen::MatrixXd& x) {
    inputs.assign(1, x);
    sums.clear();
    for (std::size_t l = 0; l < w.size(); ++l) {
      sums.push_back((inputs.back() * w[l]).rowwise() + b[l].transpose());
      if (l + 1 < w.size()) {
        inputs.push_back(sums.back().unaryExpr([this](double v) { return v > 0.0 ? v : leak * v; }));
      }
    }
    return sums.back();
  }

  Gradients backward(Eigen::MatrixXd dy) const {
    Gradients g{std::vector<Eigen::MatrixXd>(w.size()), std::vector<Eigen::VectorXd>(w.size()), {}};
    for (std::size_t l = w.size(); l-- > 0;) {
      g.w[l] = inputs[l].transpose() * dy;
      g.b[l] = dy.colwise().sum();
      g.x = dy * w[l].transpose();
      if (l > 0) {
        dy = g.x.cwiseProduct(sums[l - 1].unaryExpr([this](double v) { return v > 0.0 ? 1.0 : leak; }));
      }
    }
    return g;
  }

  std::vector<Eigen::MatrixXd> w;
  std::vector<Eigen::VectorXd> b;
  double leak;
  std::vector<Eigen::MatrixXd> inputs, sums;  // of the last forward pass
};

// Adam, algorithm 1 of Kingma and Ba 2015 line by line, after clipping the norm.
struct DoubleAdam {
  void step(DoubleNetwork& network, Gradients g, double rate, double clip) {
    double squares = 0.0;
    for (std::size_t l = 0; l < g.w.size(); ++l) squares += g.w[l].squaredNorm() + g.b[l].squaredNorm();
    const double scale = std::min(1.0, clip / std::sqrt(squares));
    if (t == 0) {
      m = g;
      for (auto& part : m.w) part.setZero();
      for (auto& part : m.b) part.setZero();
      v = m;
    }
    ++t;
    const auto update = [&](auto& theta, const auto& slope, auto& mean, auto& square) {
      for (Eigen::Index i = 0; i < theta.size(); ++i) {
        const double s = scale * slope.data()[i];
        mean.data()[i] = 0.9 * mean.data()[i] + 0.1 * s;
        square.data()[i] = 0.999 * square.data()[i] + 0.001 * s * s;
        const double m_hat = mean.data()[i] / (1.0 - std::pow(0.9, t));
        const double v_hat = square.data()[i] / (1.0 - std::pow(0.999, t));
        theta.data()[i] -= rate * m_hat / (std::sqrt(v_hat) + 1e-8);
      }
    };
    for (std::size_t l = 0; l < g.w.size(); ++l) {
      update(network.w[l], g.w[l], m.w[l], v.w[l]);
      update(network.b[l], g.b[l], m.b[l], v.b[l]);
    }
  }

  Gradients m, v;
  int t = 0;
};

// Largest difference of any weight or bias.
inline double difference(const DoubleNetwork& reference, const Network& network, const float* weights) {
  const DoubleNetwork other{network, weights};
  double largest = 0.0;
  for (std::size_t l = 0; l < other.w.size(); ++l) {
    largest = std::max({largest, (other.w[l] - reference.w[l]).cwiseAbs().maxCoeff(),
                        (other.b[l] - reference.b[l]).cwiseAbs().maxCoeff()});
  }
  return largest;
}

inline RowMatrixXf random_rows(Eigen::Index rows, Eigen::Index columns, Rng& rng) {
  RowMatrixXf m(rows, columns);
  for (float& value : m.reshaped()) value = static_cast<float>(rng.uniform(-1.0, 1.0));
  return m;
}

}  // namespace modsearch::reference
