#include <modsearch/kinematics/interruption.hpp>
#include <utility>

namespace modsearch {
namespace {

thread_local Interruptible* innermost = nullptr;

}  // namespace

Interruptible::Interruptible(std::function<bool()> stop) : stop_{std::move(stop)}, outer_{innermost} {
  innermost = this;
}

Interruptible::~Interruptible() { innermost = outer_; }

void interruption_point() {
  for (const Interruptible* scope = innermost; scope != nullptr; scope = scope->outer_) {
    if (scope->stop_()) throw Interrupted{};
  }
}

}  // namespace modsearch
