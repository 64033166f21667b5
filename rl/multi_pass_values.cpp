#include <algorithm>
#include <modsearch/rl/float_kernels_internal.hpp>
#include <modsearch/rl/linear_layer_internal.hpp>
#include <modsearch/rl/one_network_values_internal.hpp>

namespace modsearch {
namespace {

// MP-DQN: pass k sees x_k only. What the K passes share is computed once: s W_s + b of the first layer; and pass k
// needs column k of the last layer only. So K passes cost little more than one.
class MultiPassValues final : public OneNetworkValues {
 public:
  MultiPassValues(const HybridSpace& space, const Options& options, Rng rng)
      : OneNetworkValues{space, options, rng}, layers_{Network{network().shape()}.layers()} {}

  std::unique_ptr<ActionValues> clone() const override { return std::make_unique<MultiPassValues>(*this); }
  ValueKind kind() const override { return ValueKind::kMultiPass; }

  const RowMatrixXf& forward(const RowMatrixXf& s, const RowMatrixXf& x) override {
    check_states(s, x, n_s(), space());
    values_.resize(s.rows(), space().n_actions());
    run(s.rows(), {s.data(), s.cols()}, {x.data(), x.cols()}, {values_.data(), values_.cols()}, passes_);
    return values_;
  }

  const RowMatrixXf& parameters_gradient(const RowMatrixXf& dq) override {
    check_slopes(dq, passes_.rows, space());
    const Eigen::Index rows = passes_.rows;
    const int n = space().n_actions();
    dx_.resize(rows, space().n_parameters());
    const ConstRows w_last = columns(layers_.back(), w(), passes_.columns.back());
    if (layers_.size() == 1) {  // Q_k = s W_sk + x_k W_xk + b_k
      for (int k = 0; k < n; ++k) {
        const Eigen::Map<const Eigen::RowVectorXf> w_xk{w_last.data + k * w_last.stride + first_input(k),
                                                        space().count(k)};
        dx_.middleCols(space().offset(k), space().count(k)) = dq.col(k) * w_xk;
      }
      return dx_;
    }
    // dQ_k/dh of the last hidden layer is column k of the last one.
    std::size_t l = layers_.size() - 1;
    FloatBuffer* dh = &slopes_[l % 2];
    Eigen::Index stride = padded(layers_[l].inputs);
    grow(*dh, n * rows * stride);
    for (int k = 0; k < n; ++k) {
      float_kernels().multiply({.rows = rows,
                                .columns = layers_[l].inputs,
                                .depth = 1,
                                .a = dq.data() + k,
                                .a_row = dq.cols(),
                                .b = w_last.data + k * w_last.stride,
                                .c = dh->data() + k * rows * stride,
                                .c_row = stride,
                                .mask = passes_.h[l - 1].data() + k * rows * stride,
                                .mask_row = stride,
                                .leak = network().shape().leak});
    }
    for (--l; l > 0; --l) {
      const Eigen::Index below = padded(layers_[l].inputs);
      FloatBuffer& dx = slopes_[l % 2];
      grow(dx, n * rows * below);
      inputs_gradient(layers_[l], w(), n * rows, {dh->data(), stride}, {passes_.h[l - 1].data(), below},
                      network().shape().leak, {dx.data(), below}, passes_.columns[l]);
      dh = &dx;
      stride = below;
    }
    for (int k = 0; k < n; ++k) {
      float_kernels().row_dots({.rows = rows,
                                .columns = space().count(k),
                                .depth = layers_[0].outputs,
                                .a = dh->data() + k * rows * stride,
                                .a_row = stride,
                                .b = w() + layers_[0].weights + first_input(k) * layers_[0].row,
                                .b_row = layers_[0].row,
                                .c = dx_.data() + space().offset(k),
                                .c_row = dx_.cols()});
    }
    return dx_;
  }

  const Eigen::VectorXf& forward_one(const Eigen::VectorXf& s, const Eigen::VectorXf& x) override {
    check_size("columns of states", s.size(), n_s());
    check_size("columns of parameters", x.size(), space().n_parameters());
    one_.resize(space().n_actions());
    run(1, {s.data(), s.size()}, {x.data(), x.size()}, {one_.data(), one_.size()}, one_pass_);
    return one_;
  }

 private:
  // Memory of K passes: the rows of pass 0, then those of pass 1, ..
  struct Passes {
    Eigen::Index rows = -1;            // B
    FloatBuffer shared;                // s W_s + b of the first layer [B x padded]
    std::vector<FloatBuffer> h;        // [hidden layers] their outputs [K B x padded]
    std::vector<FloatBuffer> columns;  // [n_layers] W^T where it is needed
  };

  void hide_others(int k, float* x) const override {
    std::fill_n(x, space().offset(k), 0.0F);
    std::fill(x + space().offset(k) + space().count(k), x + space().n_parameters(), 0.0F);
  }

  const float* w() const { return network().parameters().data(); }
  // Number of the first of x_k among the inputs.
  Eigen::Index first_input(int k) const { return n_s() + space().offset(k); }
  static void grow(FloatBuffer& buffer, Eigen::Index size) {
    if (buffer.size() < static_cast<std::size_t>(size)) buffer.resize(static_cast<std::size_t>(size));
  }

  void run(Eigen::Index rows, ConstRows s, ConstRows x, Rows values, Passes& passes) const {
    const int n = space().n_actions();
    const float leak = network().shape().leak;
    passes.rows = rows;
    passes.h.resize(layers_.size() - 1);
    passes.columns.resize(layers_.size());
    const ConstRows w_last = columns(layers_.back(), w(), passes.columns.back());
    if (layers_.size() == 1) {
      linear(rows, s, x, w_last, values);
      return;
    }
    const LinearLayer& first = layers_.front();
    const Eigen::Index width = padded(first.outputs);
    grow(passes.shared, rows * width);
    LinearLayer states = first;  // the rows of W that belong to s come first
    states.inputs = n_s();
    modsearch::forward(states, w(), rows, s, {passes.shared.data(), width}, std::nullopt);
    grow(passes.h.front(), n * rows * width);
    for (int k = 0; k < n; ++k) {
      float_kernels().multiply({.rows = rows,
                                .columns = first.outputs,
                                .depth = space().count(k),
                                .a = x.data + space().offset(k),
                                .a_row = x.stride,
                                .b = w() + first.weights + first_input(k) * first.row,
                                .b_row = first.row,
                                .c = passes.h.front().data() + k * rows * width,
                                .c_row = width,
                                .initial = passes.shared.data(),
                                .initial_row = width,
                                .leak = leak,
                                .rectify = true});
    }
    for (std::size_t l = 1; l + 1 < layers_.size(); ++l) {
      const Eigen::Index stride = padded(layers_[l].outputs);
      grow(passes.h[l], n * rows * stride);
      modsearch::forward(layers_[l], w(), n * rows, {passes.h[l - 1].data(), padded(layers_[l].inputs)},
                         {passes.h[l].data(), stride}, leak);
    }
    const LinearLayer& last = layers_.back();
    const Eigen::Index stride = padded(last.inputs);
    for (int k = 0; k < n; ++k) {
      float_kernels().row_dots({.rows = rows,
                                .columns = 1,
                                .depth = last.inputs,
                                .a = passes.h.back().data() + k * rows * stride,
                                .a_row = stride,
                                .b = w_last.data + k * w_last.stride,
                                .c = values.data + k,
                                .c_row = values.stride,
                                .bias = w() + last.bias + k});
    }
  }

  // Without hidden layers: Q_k = s W_sk + x_k W_xk + b_k.
  void linear(Eigen::Index rows, ConstRows s, ConstRows x, ConstRows w_last, Rows values) const {
    for (Eigen::Index row = 0; row < rows; ++row) {
      for (int k = 0; k < space().n_actions(); ++k) {
        const float* const w_k = w_last.data + k * w_last.stride;
        float q = w()[layers_.back().bias + k];
        for (int i = 0; i < n_s(); ++i) q += s.data[row * s.stride + i] * w_k[i];
        for (int i = 0; i < space().count(k); ++i) {
          q += x.data[row * x.stride + space().offset(k) + i] * w_k[first_input(k) + i];
        }
        values.data[row * values.stride + k] = q;
      }
    }
  }

  std::vector<LinearLayer> layers_;
  Passes passes_, one_pass_;
  FloatBuffer slopes_[2];  // dL/dh of a layer and of the one below, by turns
  RowMatrixXf values_, dx_;
  Eigen::VectorXf one_;
};

}  // namespace

std::unique_ptr<ActionValues> make_multi_pass_values(const HybridSpace& space, const ActionValues::Options& options,
                                                     Rng rng) {
  return std::make_unique<MultiPassValues>(space, options, rng);
}

}  // namespace modsearch
