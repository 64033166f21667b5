#include "torch_pdqn.hpp"

#include <dlfcn.h>
#include <torch/torch.h>

#include <algorithm>
#include <modsearch/rl/mlp.hpp>
#include <string_view>

namespace modsearch {
namespace {

namespace nn = torch::nn;
using torch::Tensor;

const float* part(Agent& agent, std::string_view name) {
  for (const StatePart& part : agent.state()) {
    if (part.name == name) return reinterpret_cast<const float*>(part.bytes.data());
  }
  throw std::logic_error("the agent has no part of this name");
}

Tensor tensor(const Eigen::Ref<const RowMatrixXf>& m) {
  const RowMatrixXf whole = m;
  return torch::from_blob(const_cast<float*>(whole.data()), {whole.rows(), whole.cols()}).clone();
}

nn::Sequential sequential(const Network& network, const float* w, torch::Dtype type) {
  nn::Sequential result;
  torch::NoGradGuard no_gradient;
  for (int l = 0; l < static_cast<int>(network.layers().size()); ++l) {
    if (l > 0) result->push_back(nn::ReLU{});
    const RowMatrixXf weights = Mlp::weights(network, const_cast<float*>(w), l).transpose();
    const RowMatrixXf bias = Mlp::bias(network, const_cast<float*>(w), l);
    nn::Linear linear{weights.cols(), weights.rows()};
    linear->weight.copy_(tensor(weights));
    linear->bias.copy_(tensor(bias).squeeze(1));
    result->push_back(linear);
  }
  result->to(type);
  return result;
}

double largest_difference(const nn::Sequential& a, const nn::Sequential& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a->parameters().size(); ++i) {
    const Tensor difference = a->parameters()[i].to(torch::kFloat64) - b->parameters()[i].to(torch::kFloat64);
    largest = std::max(largest, difference.abs().max().item<double>());
  }
  return largest;
}

void follow(const nn::Sequential& target, const nn::Sequential& source, double tau) {
  torch::NoGradGuard no_gradient;
  const std::vector<Tensor> to = target->parameters(), from = source->parameters();
  for (std::size_t i = 0; i < to.size(); ++i) to[i].mul_(1.0 - tau).add_(from[i], tau);
}

}  // namespace

std::string torch_blas() {
  const auto config = reinterpret_cast<const char* (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_config"));
  if (config != nullptr) return config();
  return dlsym(RTLD_DEFAULT, "ATL_buildinfo") != nullptr ? "ATLAS" : "neither OpenBLAS nor ATLAS";
}

struct TorchPdqn::Memory {
  Memory(ValueKind the_kind, Agent& agent, const AgentOptions& the_options, bool in_double)
      : kind{the_kind},
        options{the_options},
        type{in_double ? torch::kFloat64 : torch::kFloat32},
        space{agent.space()},
        value_network{{.inputs = agent.observation_size() + space.n_parameters(),
                       .hidden = options.value_hidden,
                       .outputs = space.n_actions()}},
        actor_network{
            {.inputs = agent.observation_size(), .hidden = options.actor_hidden, .outputs = space.n_parameters()}},
        q{sequential(value_network, part(agent, "q0"), type)},
        q_target{sequential(value_network, part(agent, "q0"), type)},
        mu{sequential(actor_network, part(agent, "mu"), type)},
        mu_target{sequential(actor_network, part(agent, "mu"), type)},
        q_adam{q->parameters(), torch::optim::AdamOptions{options.value_rate}},
        mu_adam{mu->parameters(), torch::optim::AdamOptions{options.actor_rate}} {
    torch::set_num_threads(1);
    const int n_s = agent.observation_size(), n = space.n_parameters();
    const float* const passthrough = part(agent, "mu.passthrough");  // W [n x n_s] by columns, then b
    passthrough_w = tensor(Eigen::Map<const RowMatrixXf>{passthrough, n_s, n}).to(type);
    passthrough_b = tensor(Eigen::Map<const RowMatrixXf>{passthrough + n * n_s, 1, n}).to(type);
    for (int k = 0; k < space.n_actions(); ++k) {
      Tensor mask = torch::zeros({1, n}, type);
      mask.slice(1, space.offset(k), space.offset(k) + space.count(k)).fill_(1.0);
      masks.push_back(mask);
    }
  }

  Tensor proposals(nn::Sequential& network, const Tensor& s) const {
    return network->forward(s) + torch::matmul(s, passthrough_w) + passthrough_b;
  }

  // MP-DQN as its authors wrote it: all passes in one batch, of which the diagonal blocks count.
  Tensor values(nn::Sequential& network, const Tensor& s, const Tensor& x) const {
    if (kind == ValueKind::kJoint) return network->forward(torch::cat({s, x}, 1));
    std::vector<Tensor> inputs;
    for (const Tensor& mask : masks) inputs.push_back(torch::cat({s, x * mask}, 1));
    const Tensor all = network->forward(torch::cat(inputs, 0));
    std::vector<Tensor> columns;
    for (std::size_t k = 0; k < masks.size(); ++k) {
      const auto pass = static_cast<std::int64_t>(k);
      columns.push_back(all.slice(0, pass * s.size(0), (pass + 1) * s.size(0)).select(1, pass).unsqueeze(1));
    }
    return torch::cat(columns, 1);
  }

  ValueKind kind;
  AgentOptions options;
  torch::Dtype type;
  HybridSpace space;
  Network value_network, actor_network;
  mutable nn::Sequential q, q_target, mu, mu_target;
  torch::optim::Adam q_adam, mu_adam;
  Tensor passthrough_w, passthrough_b;
  std::vector<Tensor> masks;
  Tensor s, x, k, reward, discount, s_next;
};

TorchPdqn::TorchPdqn(ValueKind kind, Agent& agent, const AgentOptions& options, bool in_double)
    : memory_{std::make_unique<Memory>(kind, agent, options, in_double)} {}

TorchPdqn::~TorchPdqn() = default;

void TorchPdqn::set_batch(const Batch& batch) {
  Memory& m = *memory_;
  m.s = tensor(batch.s).to(m.type);
  m.x = tensor(batch.x).to(m.type);
  m.k = tensor(batch.k.cast<float>()).to(torch::kInt64);
  m.reward = tensor(batch.reward).to(m.type);
  m.discount = tensor(batch.discount).to(m.type);
  m.s_next = tensor(batch.s_next).to(m.type);
}

void TorchPdqn::update() {
  Memory& m = *memory_;
  Tensor y;
  {
    torch::NoGradGuard no_gradient;
    const Tensor next = m.values(m.q_target, m.s_next, m.proposals(m.mu_target, m.s_next));
    y = m.reward + m.discount * std::get<0>(next.max(1, true));
  }
  const Tensor loss = torch::mse_loss(m.values(m.q, m.s, m.x).gather(1, m.k), y);
  m.q_adam.zero_grad();
  loss.backward();
  nn::utils::clip_grad_norm_(m.q->parameters(), m.options.clip);
  m.q_adam.step();

  const Tensor x = m.proposals(m.mu, m.s);
  const Tensor at = x.detach().requires_grad_(true);
  const Tensor objective = m.values(m.q, m.s, at).sum() / static_cast<double>(x.size(0));
  Tensor g = torch::autograd::grad({objective}, {at})[0];
  g = g * torch::where(g > 0.0, (1.0 - at.detach()) / 2.0, (at.detach() + 1.0) / 2.0);
  m.mu_adam.zero_grad();
  x.backward(-g);
  nn::utils::clip_grad_norm_(m.mu->parameters(), m.options.clip);
  m.mu_adam.step();
  follow(m.q_target, m.q, m.options.value_tau);
  follow(m.mu_target, m.mu, m.options.actor_tau);
}

int TorchPdqn::act(const Eigen::VectorXf& s) const {
  torch::NoGradGuard no_gradient;
  Memory& m = *memory_;
  const Tensor state = torch::from_blob(const_cast<float*>(s.data()), {1, s.size()}).to(m.type);
  const Tensor x = m.proposals(m.mu, state).clamp(-1.0, 1.0);
  return m.values(m.q, state, x).argmax(1).item<int>();
}

double TorchPdqn::difference(Agent& agent) const {
  const Memory& m = *memory_;
  return std::max(largest_difference(m.q, sequential(m.value_network, part(agent, "q0"), torch::kFloat32)),
                  largest_difference(m.mu, sequential(m.actor_network, part(agent, "mu"), torch::kFloat32)));
}

}  // namespace modsearch
