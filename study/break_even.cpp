#include <fmt/format.h>

#include <cmath>
#include <modsearch/study/break_even.hpp>
#include <stdexcept>

namespace modsearch {

double break_even_tasks(const AmortisedCost& trained, double classical) {
  for (const double cost : {trained.training, trained.use, classical}) {
    if (!(cost >= 0.0)) throw std::invalid_argument(fmt::format("break_even_tasks: a cost is {}", cost));
  }
  if (!(trained.use < classical)) return INFINITY;  // also where neither meets the quality
  return trained.training / (classical - trained.use);
}

}  // namespace modsearch
