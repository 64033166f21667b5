#include <algorithm>
#include <checker/bound.hpp>
#include <checker/rows.hpp>

namespace modsearch_check {
namespace {

/// a . R_j(q) b(z) of one goal: a summand of F.
struct Term {
  Vector a{};
  AffineVector b;      // in the coordinates of frame j
  AffineVector world;  // R_j b at the centre of the angles
  std::size_t acting = 0;
};

/// The terms of one frame at one goal: together <M, R_j> with M = sum of a b'.
struct FrameTerms {
  std::size_t goal = 0;
  std::vector<Term> terms;
  std::size_t acting = 0;  // the most of its terms
  double delta = 0.0;      // of those joints together
};

struct Sum {
  std::vector<Angles> angles;  // per goal
  std::vector<FrameTerms> frames;
  Interval constant;  // sum_g (y . t - radius |y|) + sum mu beta
};

Term term(const Vector& a, const AffineVector& b, const Matrix& R, std::size_t acting) { return {a, b, R * b, acting}; }

Sum sum_of(const Problem& problem, const Model& model, const Box& box, const Leaf& leaf) {
  Sum sum;
  for (std::size_t g = 0; g < problem.task.goals.size(); ++g) {
    const Goal& goal = problem.task.goals[g];
    const Vector y = vector_of(leaf.y[g]);
    sum.constant += dot(y, vector_of(goal.position)) - (Interval{goal.radius} + kSlack) * norm(y);
    const Angles& angles = sum.angles.emplace_back(model, box, g);
    std::vector<FrameTerms> frames(model.frames.size());
    std::vector<Vector> pull(model.frames.size(), y);  // on the vectors of each frame
    for (const Row& row : leaf.rows) {
      if (row.goal != g) continue;
      const Inequality keep_away = inequality(problem, model, box, angles, row);
      const Vector push = Interval{row.mu} * keep_away.normal;
      sum.constant += Interval{row.mu} * keep_away.beta;
      const std::size_t j = keep_away.frame;
      for (std::size_t i = 0; i < j; ++i) pull[i] = pull[i] + push;
      frames[j].terms.push_back(term(push, keep_away.point, angles.centre.turn[j], model.acting(j, keep_away.point)));
    }
    for (std::size_t j = 0; j < frames.size(); ++j) {
      FrameTerms& frame = frames[j];
      frame.goal = g;
      frame.terms.push_back(term(pull[j], model.frames[j].v, angles.centre.turn[j], model.frames[j].acting));
      for (const Term& t : frame.terms) frame.acting = std::max(frame.acting, t.acting);
      frame.delta = angles.delta[frame.acting];
      sum.frames.push_back(std::move(frame));
    }
  }
  return sum;
}

/// Linear in the lengths: [constant, coefficients].
using Form = std::vector<Interval>;

Interval at(const Form& form, const std::vector<double>& z) {
  Interval value = form[0];
  for (std::size_t i = 0; i < z.size(); ++i) value += form[i + 1] * z[i];
  return value;
}

/// Adds a . b(z).
void add_product(Form& form, const Vector& a, const AffineVector& b) {
  form[0] += dot(a, b.offset);
  for (std::size_t i = 0; i < b.columns.size(); ++i) form[i + 1] += dot(a, b.columns[i]);
}

AffineVector cross(const Vector& a, const AffineVector& b) {
  AffineVector result{cross(a, b.offset), {}};
  for (const Vector& c : b.columns) result.columns.push_back(modsearch_check::cross(a, c));
  return result;
}

std::vector<std::vector<double>> corners(const Model& model, const Box& box) {
  std::vector<std::vector<double>> result(std::size_t{1} << model.n_lengths(), std::vector<double>(model.n_lengths()));
  for (std::size_t c = 0; c < result.size(); ++c) {
    for (std::size_t i = 0; i < model.n_lengths(); ++i) result[c][i] = (c >> i) % 2 == 0 ? box.lower[i] : box.upper[i];
  }
  return result;
}

Form mass_form(const Model& model, const Leaf& leaf) {
  Form form(model.n_lengths() + 1);
  if (!leaf.mass) return form;
  form[0] = model.mass.offset;
  std::copy(model.mass.columns.begin(), model.mass.columns.end(), form.begin() + 1);
  return form;
}

// Four bounds of what Taylor's series leaves out of the terms of a frame, of which any one may be used at all corners.
using Choices = std::array<double, 4>;

/// The remainder of one frame's terms, <M, R_j>: with |M| the nuclear norm, M = sum of a b',
///     |M| delta^2 / 2,  or  1/2 sum_v max(0, h_v^2 H_vv + sum over w != v of h_v h_w |H_vw|) + |M| delta^3 / 6,
/// because no derivative of a product of rotations is longer than one. (With |s_v| <= 1 the quadratic form is at most
/// sum_v s_v^2 of what stands behind the max: s_v s_w <= (s_v^2 + s_w^2) / 2.) |M| is at most the sum of |a| |b|, and
/// at most the sum of the lengths of the columns of M.
class Remainder {
 public:
  Remainder(const FrameTerms& frame, const Angles& angles, std::size_t n_lengths) : frame_{&frame}, angles_{&angles} {
    const std::size_t n = frame.acting;
    second_.assign(n * n, {});
    for (const Term& t : frame.terms) {
      length_.push_back(norm(t.a));
      for (std::size_t w = 0; w < t.acting; ++w) {
        const AffineVector turned = cross(angles.centre.axis[w], t.world);
        for (std::size_t v = 0; v <= w; ++v) {
          Form& form = second_[v * n + w];
          if (form.empty()) form.resize(n_lengths + 1);
          add_product(form, modsearch_check::cross(t.a, angles.centre.axis[v]), turned);  // a . (w_v x (w_w x b))
        }
      }
    }
  }

  [[nodiscard]] Choices at_corner(const std::vector<double>& z) const {
    Interval products = 0.0;
    Matrix M{};  // columns as rows
    for (std::size_t t = 0; t < frame_->terms.size(); ++t) {
      const Vector b = frame_->terms[t].b.at(z);
      products += length_[t] * norm(b);
      for (std::size_t c = 0; c < 3; ++c) M[c] = M[c] + b[c] * frame_->terms[t].a;
    }
    const double columns = (norm(M[0]) + norm(M[1]) + norm(M[2])).upper();
    const Interval size = products.upper();
    const Interval delta = frame_->delta;
    const Interval square_part = delta * delta * 0.5;
    const Interval cube_part = delta * delta * delta / 6.0;
    const double bent = curvature(z);
    return {(square_part * size).upper(), (square_part * columns).upper(), (Interval{bent} + cube_part * size).upper(),
            (Interval{bent} + cube_part * columns).upper()};
  }

 private:
  [[nodiscard]] double curvature(const std::vector<double>& z) const {
    const std::size_t n = frame_->acting;
    std::vector<Interval> rows(n);
    for (std::size_t w = 0; w < n; ++w) {
      for (std::size_t v = 0; v <= w; ++v) {
        const Interval entry = at(second_[v * n + w], z) * angles_->half[v] * angles_->half[w];
        rows[v] += v == w ? entry : abs(entry);
        if (v != w) rows[w] += abs(entry);
      }
    }
    double sum = 0.0;
    for (const Interval& row : rows) sum += std::max(0.0, row.upper());
    return 0.5 * sum;
  }

  const FrameTerms* frame_;
  const Angles* angles_;
  std::vector<Interval> length_;  // |a| of each term
  std::vector<Form> second_;      // second derivatives [acting x acting], upper triangle
};

Corners second_order(const Model& model, const Box& box, const Leaf& leaf, const Sum& sum) {
  Corners result;
  const std::size_t n = model.n_joints();
  Form rest = mass_form(model, leaf);                                            // mass - F at the centre
  std::vector<Form> slopes(sum.angles.size() * n, Form(model.n_lengths() + 1));  // dF/dq_v there
  std::vector<Remainder> remainders;
  for (const FrameTerms& frame : sum.frames) {
    const Angles& angles = sum.angles[frame.goal];
    for (const Term& t : frame.terms) {
      add_product(rest, -t.a, t.world);
      for (std::size_t v = 0; v < t.acting; ++v) {
        add_product(slopes[frame.goal * n + v], modsearch_check::cross(t.a, angles.centre.axis[v]), t.world);
      }
    }
    if (frame.acting > 0) remainders.emplace_back(frame, angles, model.n_lengths());
  }

  const std::vector<std::vector<double>> all = corners(model, box);
  std::vector<std::vector<Choices>> choices(all.size());
  std::size_t worst = 0;
  double least = INFINITY;
  for (std::size_t c = 0; c < all.size(); ++c) {
    Interval before = at(rest, all[c]);  // remainders
    std::vector<Interval>& here = result.slopes.emplace_back();
    for (std::size_t v = 0; v < slopes.size(); ++v) {
      here.push_back(at(slopes[v], all[c]));
      before -= abs(here.back()) * sum.angles[v / n].half[v % n];
    }
    double best = before.lower();
    for (const Remainder& remainder : remainders) {
      choices[c].push_back(remainder.at_corner(all[c]));
      best -= *std::min_element(choices[c].back().begin(), choices[c].back().end());
    }
    if (best < least) {
      least = best;
      worst = c;
    }
    result.values.push_back(before);
  }
  // One choice per frame for all corners (a minimum of convex functions need not be convex): the best at the worst one.
  for (std::size_t c = 0; c < all.size(); ++c) {
    for (std::size_t k = 0; k < remainders.size(); ++k) {
      const Choices& there = choices[worst][k];
      const auto chosen = static_cast<std::size_t>(std::min_element(there.begin(), there.end()) - there.begin());
      result.values[c] -= choices[c][k][chosen];
    }
  }
  return result;
}

/// First order: a . w for a w that is as long as b and at most delta away from R_j b in angle.
Corners cap_order(const Model& model, const Box& box, const Leaf& leaf, const Sum& sum) {
  Corners result;
  const Form mass = mass_form(model, leaf);
  const std::vector<std::vector<double>> all = corners(model, box);
  for (const std::vector<double>& z : all) result.values.push_back(at(mass, z));
  for (const FrameTerms& frame : sum.frames) {
    for (const Term& t : frame.terms) {
      const double delta = sum.angles[frame.goal].delta[t.acting];
      const Interval length = norm(t.a);
      const SinCos turn = sin_cos(std::min(delta, 3.14));
      for (std::size_t c = 0; c < all.size(); ++c) {
        const Vector b = t.world.at(all[c]);
        const Interval longest = length * norm(b);
        const Interval along = dot(t.a, b);
        double most = longest.upper();
        if (delta < 3.14 && along.upper() < (longest * turn.cos).lower()) {
          const Interval edge = along * turn.cos + norm(modsearch_check::cross(t.a, b)) * turn.sin;
          most = std::min(most, edge.upper());
        }
        result.values[c] -= most;
      }
    }
  }
  return result;
}

}  // namespace

Shown::Shown(const Problem& problem, const Model& model, const Box& box, const Leaf& leaf)
    : box_{box}, n_lengths_{model.n_lengths()}, cap_{leaf.cap} {
  const Sum sum = sum_of(problem, model, box, leaf);
  for (const Angles& angles : sum.angles) {
    middle_.insert(middle_.end(), angles.middle.begin(), angles.middle.end());
    half_.insert(half_.end(), angles.half.begin(), angles.half.end());
  }
  corners_ = cap_ ? cap_order(model, box, leaf, sum) : second_order(model, box, leaf, sum);
  for (Interval& value : corners_.values) value += sum.constant;
}

double Shown::in_box() const {
  double bound = INFINITY;
  for (const Interval& value : corners_.values) bound = std::min(bound, value.lower());
  return bound;
}

double Shown::in_part(std::size_t variable, double at, bool above) const {
  const std::vector<Interval>& values = corners_.values;
  double bound = INFINITY;
  if (variable < n_lengths_) {
    const Interval width = Interval{box_.upper[variable]} - Interval{box_.lower[variable]};
    if (!(width.lower() > 0.0)) return in_box();
    const Interval share = (Interval{at} - Interval{box_.lower[variable]}) / width;
    const std::size_t bit = std::size_t{1} << variable;
    for (std::size_t c = 0; c < values.size(); ++c) {
      if ((c & bit) != 0) continue;
      const Interval chord = (Interval{1.0} - share) * values[c] + share * values[c | bit];
      bound = std::min({bound, chord.lower(), (above ? values[c | bit] : values[c]).lower()});
    }
    return bound;
  }
  if (cap_) throw Rejected("a first-order form shows nothing about a part of the angles");
  const std::size_t v = variable - n_lengths_;
  const Interval place = Interval{at} - Interval{middle_[v]};
  const Interval end = above ? half_[v] : -half_[v];
  for (std::size_t c = 0; c < values.size(); ++c) {
    const Interval& slope = corners_.slopes[c][v];
    const Interval without = values[c] + abs(slope) * half_[v];
    bound = std::min({bound, (without - slope * place).lower(), (without - slope * end).lower()});
  }
  return bound;
}

Box root_box(const Model& model, std::size_t n_goals) {
  Box box{model.lower, model.upper};
  for (std::size_t g = 0; g < n_goals; ++g) {
    for (std::size_t j = 0; j < model.n_joints(); ++j) {
      const bool takes_over = j > 0 && model.idle[j - 1];  // turns for the joint before it too
      const Interval limits = Interval{model.joints[j].lower, model.joints[j].upper} + Interval{-kSlack, kSlack};
      box.lower.push_back(model.idle[j] ? 0.0 : takes_over ? -kPiUp : limits.lower());
      box.upper.push_back(model.idle[j] ? 0.0 : takes_over ? kPiUp : limits.upper());
    }
  }
  return box;
}

double lower_bound(const Problem& problem, const Model& model, const Box& box, const Leaf& leaf) {
  return Shown{problem, model, box, leaf}.in_box();
}

}  // namespace modsearch_check
