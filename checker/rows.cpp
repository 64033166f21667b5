#include <checker/rows.hpp>

namespace modsearch_check {
namespace {

/// Largest |R b - R' b| / |b| for rotations R, R' at most `delta` apart.
Interval greatest_chord(double delta) {
  return delta >= 3.14 ? Interval{2.0} : Interval{2.0} * sin_cos(0.5 * delta).sin;
}

std::vector<double> centre_of_lengths(const Model& model, const Box& box) {
  std::vector<double> centre(model.n_lengths());
  for (std::size_t i = 0; i < centre.size(); ++i) centre[i] = 0.5 * (box.lower[i] + box.upper[i]);
  return centre;
}

/// Obstacles have constant sizes.
Interval size_of(const Shape& shape, std::size_t i) { return shape.size[i].offset; }

void check_ball_inside(const Shape& shape, const Row& row) {
  const Vector c = transposed(shape.pose.turn) * (vector_of(row.centre) - shape.pose.move.offset);
  const Interval rho = row.radius;
  bool inside = false;
  switch (shape.kind) {
    case Kind::kSphere:
      inside = (norm(vector_of(row.centre) - shape.pose.move.offset) + rho).upper() <= size_of(shape, 0).lower();
      break;
    case Kind::kBox:
      inside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        inside = inside && (abs(c[k]) + rho).upper() <= 0.5 * size_of(shape, k).lower();
      }
      break;
    case Kind::kCylinder:
      inside = (norm({c[0], c[1], 0.0}) + rho).upper() <= size_of(shape, 0).lower() &&
               (abs(c[2]) + rho).upper() <= 0.5 * size_of(shape, 1).lower();
      break;
    case Kind::kMesh:
      break;  // a surface: nothing is inside
  }
  if (!(row.radius >= 0.0) || !inside) throw Rejected("the ball of a row sticks out of its obstacle");
}

}  // namespace

Angles::Angles(const Model& model, const Box& box, std::size_t goal)
    : middle(model.n_joints()), half(model.n_joints()), delta{0.0}, centre{[&] {
        const std::size_t first = model.n_lengths() + goal * model.n_joints();
        for (std::size_t j = 0; j < model.n_joints(); ++j) {
          const double lower = box.lower[first + j];
          const double upper = box.upper[first + j];
          middle[j] = 0.5 * (lower + upper);
          half[j] = std::max(upper - middle[j], middle[j] - lower);
          delta.push_back(delta.back() + half[j]);
        }
        return Posture{model, middle.data()};
      }()} {}

Inequality inequality(const Problem& problem, const Model& model, const Box& box, const Angles& angles,
                      const Row& row) {
  const Run& run = model.runs[row.run];
  const Shape& shape = problem.task.obstacles[row.shape];
  if (!run.usable) throw Rejected("a row uses a body that no row may use");
  const Interval r = run.radius;
  const Interval tau = row.tau;

  // The ball of radius r about a point of the inner axis lies in the body, as long as the body is long enough.
  const AffineVector along = run.end + Interval{-1.0} * run.start;
  Interval length = dot(along.offset, run.axis);
  for (std::size_t i = 0; i < model.n_lengths(); ++i) {
    length += dot(along.columns[i], run.axis) * Interval{box.lower[i], box.upper[i]};
  }
  if (!(length.lower() >= 2.0 * run.radius)) throw Rejected("a row uses a body that may be shorter than it is thick");
  Inequality result;
  result.frame = run.frame;
  result.point = (Interval{1.0} - tau) * run.start + tau * run.end;
  result.point.offset = result.point.offset + (Interval{1.0} - Interval{2.0} * tau) * r * run.axis;

  // Where the point is at the centre of the box, and how far from there it can be in it.
  const std::vector<double> z = centre_of_lengths(model, box);
  Vector x{};
  Interval distance = 0.0;
  std::vector<Interval> stretch(z.size());
  for (std::size_t j = 0; j <= run.frame; ++j) {
    const bool last = j == run.frame;
    const AffineVector& piece = last ? result.point : model.frames[j].v;
    std::size_t acting = model.frames[j].acting;
    if (last) acting = std::max(acting, model.acting(j, piece));
    const Vector at_centre = piece.at(z);
    x = x + angles.centre.turn[j] * at_centre;
    distance += norm(at_centre) * greatest_chord(angles.delta[acting]);
    for (std::size_t i = 0; i < z.size(); ++i) stretch[i] += norm(piece.columns[i]);
  }
  for (std::size_t i = 0; i < z.size(); ++i) {
    distance += stretch[i] * std::max(box.upper[i] - z[i], z[i] - box.lower[i]);
  }

  // How far a body that counts as free may be inside, and one of several pieces fall short of being one.
  const Interval keep = Interval{-kSlack} - run.slack;
  if (row.ball) {
    // |x - b|^2 >= R^2 minus |x - x_c|^2 <= D^2, which is linear: 2 (x_c - b) . x >= R^2 - D^2 + |x_c|^2 - |b|^2.
    check_ball_inside(shape, row);
    const Numbers near = middle(x);
    const Vector x_c = vector_of(near);
    const Vector b = vector_of(row.centre);
    const Interval R = Interval{row.radius} + r + keep;
    if (!(R.lower() >= 0.0 && row.radius >= run.slack)) throw Rejected("a row is about a ball of no size");
    const Interval D = distance + norm(x - x_c);
    result.normal = Interval{2.0} * (x_c - b);
    result.beta = (square(R) - square(D) + dot(x_c, x_c) - dot(b, b)).lower();
    return result;
  }
  // Beside the box the nearest place is a face while the point stays within the face's edges; of the two sides that
  // this leaves, the far one has to be out of reach.
  if (shape.kind != Kind::kBox) throw Rejected("a row names the face of what is no box");
  const std::size_t axis = row.face / 2;
  const Interval sign = row.face % 2 == 0 ? 1.0 : -1.0;
  const Vector local = transposed(shape.pose.turn) * (x - shape.pose.move.offset);
  for (std::size_t k = 0; k < 3; ++k) {
    if (k != axis && !((abs(local[k]) + distance).upper() <= 0.5 * size_of(shape, k).lower())) {
      throw Rejected("the body point of a row may leave the sides of its face");
    }
  }
  const Interval out = Interval{0.5} * size_of(shape, axis) + r + keep;
  if (!((sign * local[axis] - distance).lower() > (-out).upper())) {
    throw Rejected("the body point of a row may be on the far side of its box");
  }
  result.normal = sign * column(shape.pose.turn, axis);
  result.beta = (dot(result.normal, shape.pose.move.offset) + out).lower();
  return result;
}

}  // namespace modsearch_check
