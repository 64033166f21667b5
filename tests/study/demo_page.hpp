#pragma once

#include <modsearch/study/page.hpp>

namespace modsearch::testing {

/// A page with one of everything: an arm of a base and two hinges between two spheres and a box, a target with its
/// sampling region, a path of `samples` (at least 1) samples from upright to the target, a trace with both standings.
[[nodiscard]] Page demo_page(int samples = 60);

}  // namespace modsearch::testing
