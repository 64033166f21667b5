// The source of the kernels of simultaneous inverse kinematics, included once per instruction set by
// simultaneous_ik_<isa>.cpp, which define kTable, the name of the table to fill. GCC's vector extensions and plain
// pointers. Compiled without contraction of products and sums, so that every instruction set gives the same bits.

namespace modsearch::detail {
namespace {

typedef double Lanes __attribute__((vector_size(8 * kIkLanes)));
typedef long long Mask __attribute__((vector_size(8 * kIkLanes)));

inline Lanes& at(double* p, std::size_t i) { return reinterpret_cast<Lanes*>(p)[i]; }
inline Lanes all(double value) { return value - Lanes{}; }
inline Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes greatest(Lanes a, Lanes b) { return a > b ? a : b; }

struct Vec3 {
  Lanes x, y, z;
};
inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(const Vec3& a, Lanes s) { return {a.x * s, a.y * s, a.z * s}; }
inline Lanes dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// M v, the matrix row by row.
inline Vec3 times(const double* M, const Vec3& v) {
  return {M[0] * v.x + M[1] * v.y + M[2] * v.z, M[3] * v.x + M[4] * v.y + M[5] * v.z,
          M[6] * v.x + M[7] * v.y + M[8] * v.z};
}
// M^T v.
inline Vec3 times_transposed(const double* M, const Vec3& v) {
  return {M[0] * v.x + M[3] * v.y + M[6] * v.z, M[1] * v.x + M[4] * v.y + M[7] * v.z,
          M[2] * v.x + M[5] * v.y + M[8] * v.z};
}

// Sine and cosine. Reduction to [-pi/4, pi/4] by pi/2 in two parts (angles here are a few turns), then the polynomials
// of Cephes (S. Moshier): errors of some 1e-16.
inline void sine_cosine(Lanes angle, Lanes& sine, Lanes& cosine) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to a whole number
  const Lanes shifted = angle * 0.63661977236758134308 + kRound;
  const Mask quadrant = reinterpret_cast<Mask>(shifted);
  const Lanes n = shifted - kRound;
  const Lanes r = (angle - n * 1.57079632673412561417e+00) - n * 6.07710050650619224932e-11;
  const Lanes z = r * r;
  Lanes s = 1.58962301576546568060e-10 * z - 2.50507477628578072866e-8;
  s = s * z + 2.75573136213857245213e-6;
  s = s * z - 1.98412698295895385996e-4;
  s = s * z + 8.33333333332211858878e-3;
  s = s * z - 1.66666666666666307295e-1;
  s = r + r * (z * s);
  Lanes c = -1.13585365213876817300e-11 * z + 2.08757008419747316778e-9;
  c = c * z - 2.75573141792967388112e-7;
  c = c * z + 2.48015872888517045348e-5;
  c = c * z - 1.38888888888730564116e-3;
  c = c * z + 4.16666666666665929218e-2;
  c = 1.0 - 0.5 * z + z * z * c;
  const Mask swap = (quadrant & 1) != 0;
  const Lanes a = swap ? c : s;
  const Lanes b = swap ? s : c;
  sine = (quadrant & 2) != 0 ? -a : a;
  cosine = ((quadrant + 1) & 2) != 0 ? -b : b;
}

// A frame of the chain in the world: three axes and the origin.
struct Frame {
  Vec3 x, y, z, p;
};

// Where the parts of the normal equations begin, in vectors.
struct Layout {
  explicit Layout(const IkModel& m)
      : n_q{static_cast<std::size_t>(m.n_joints)},
        n_x{static_cast<std::size_t>(m.n_parameters)},
        blocks{static_cast<std::size_t>(ik_variables(m))},
        block_size{ik_triangle(m.n_joints) + n_q * n_x},
        shared{blocks + static_cast<std::size_t>(m.n_goals) * block_size} {}
  std::size_t n_q, n_x;
  std::size_t blocks;      // behind the gradient
  std::size_t block_size;  // of one goal: its joints' triangle, then joints x parameters
  std::size_t shared;      // the parameters' triangle
  [[nodiscard]] std::size_t joints(std::size_t goal) const { return blocks + goal * block_size; }
  [[nodiscard]] std::size_t coupling(std::size_t goal) const {
    return joints(goal) + ik_triangle(static_cast<int>(n_q));
  }
};

inline std::size_t triangle_at(std::size_t row, std::size_t column) { return row * (row + 1) / 2 + column; }

// The frame turned about its own z axis.
inline void turn(Frame& f, Lanes angle) {
  Lanes s, c;
  sine_cosine(angle, s, c);
  const Vec3 x = f.x * c + f.y * s;
  f.y = f.y * c - f.x * s;
  f.x = x;
}

// Walks along the chain with the joints `q`, keeping per link the frame before it; gives the tip.
Frame walk(const IkModel& m, double* x, double* q, Frame* frames) {
  Frame f{{all(1.0), Lanes{}, Lanes{}}, {Lanes{}, all(1.0), Lanes{}}, {Lanes{}, Lanes{}, all(1.0)}, {}};
  for (int i = 0; i < m.n_links; ++i) {
    const IkLink& link = m.links[i];
    frames[i] = f;
    switch (link.kind) {
      case IkLink::Kind::kRigid: {
        Vec3 t{all(link.offset[0]), all(link.offset[1]), all(link.offset[2])};
        for (int k = 0; k < link.n_terms; ++k) {
          const IkTerm& term = m.terms[link.first_term + k];
          const Lanes value = at(x, static_cast<std::size_t>(term.parameter));
          t = t + Vec3{term.direction[0] * value, term.direction[1] * value, term.direction[2] * value};
        }
        f.p = f.p + f.x * t.x + f.y * t.y + f.z * t.z;
        if (link.rotates) {
          const double* R = link.rotation;
          const Frame g = f;
          f.x = g.x * all(R[0]) + g.y * all(R[3]) + g.z * all(R[6]);
          f.y = g.x * all(R[1]) + g.y * all(R[4]) + g.z * all(R[7]);
          f.z = g.x * all(R[2]) + g.y * all(R[5]) + g.z * all(R[8]);
        }
        break;
      }
      case IkLink::Kind::kTwist: {
        Lanes angle = all(link.offset[0]);
        for (int k = 0; k < link.n_terms; ++k) {
          const IkTerm& term = m.terms[link.first_term + k];
          angle += term.scale * at(x, static_cast<std::size_t>(term.parameter));
        }
        turn(f, angle);
        break;
      }
      case IkLink::Kind::kTurn:
        turn(f, at(q, static_cast<std::size_t>(link.joint)));
        break;
      case IkLink::Kind::kSlide:
        f.p = f.p + f.z * at(q, static_cast<std::size_t>(link.joint));
        break;
    }
  }
  return f;
}

// A column of the tip's Jacobian: what moves and what turns.
struct Column {
  Vec3 p, w;
};

// Columns of the joints, then of the parameters.
void columns_of(const IkModel& m, const Frame* frames, const Vec3& tip, Column* columns) {
  for (int i = 0; i < m.n_parameters; ++i) columns[m.n_joints + i] = Column{};
  for (int i = 0; i < m.n_links; ++i) {
    const IkLink& link = m.links[i];
    const Frame& f = frames[i];
    switch (link.kind) {
      case IkLink::Kind::kRigid:
        for (int k = 0; k < link.n_terms; ++k) {
          const IkTerm& term = m.terms[link.first_term + k];
          Column& column = columns[m.n_joints + term.parameter];
          column.p =
              column.p + f.x * all(term.direction[0]) + f.y * all(term.direction[1]) + f.z * all(term.direction[2]);
        }
        break;
      case IkLink::Kind::kTwist: {
        const Vec3 moves = cross(f.z, tip - f.p);
        for (int k = 0; k < link.n_terms; ++k) {
          const IkTerm& term = m.terms[link.first_term + k];
          Column& column = columns[m.n_joints + term.parameter];
          column.p = column.p + moves * all(term.scale);
          column.w = column.w + f.z * all(term.scale);
        }
        break;
      }
      case IkLink::Kind::kTurn:
        columns[link.joint] = Column{cross(f.z, tip - f.p), f.z};
        break;
      case IkLink::Kind::kSlide:
        columns[link.joint] = Column{f.z, Vec3{}};
        break;
    }
  }
}

// The part of a row's value that is outside its interval.
inline Lanes outside(Lanes value, double lower, double upper) {
  return value - least(greatest(value, all(lower)), all(upper));
}

// Rows of a goal in the frame M: residuals outside their intervals, and columns that count only where these are not 0.
inline void as_rows(const double* M, const IkTarget& target, int first, Vec3& residual) {
  residual = times(M, residual);
  residual = {target.weight[first] * outside(residual.x, target.lower[first], target.upper[first]),
              target.weight[first + 1] * outside(residual.y, target.lower[first + 1], target.upper[first + 1]),
              target.weight[first + 2] * outside(residual.z, target.lower[first + 2], target.upper[first + 2])};
}
inline Vec3 counting(const double* M, const Vec3& residual, const Vec3& column) {
  const Vec3 rows = times(M, column);
  return {residual.x != 0.0 ? rows.x : Lanes{}, residual.y != 0.0 ? rows.y : Lanes{},
          residual.z != 0.0 ? rows.z : Lanes{}};
}

// Cost and normal equations of the least squares at `v`.
//
// A goal's rotation counts by 1 - cos(angle): half the squared difference of the rotation matrices, whose Gauss-Newton
// model is that of the rotation vector while no angle has to be found. Its gradient is sin(angle) times the axis.
void evaluate(const IkModel& m, const Layout& layout, double* v, double* normal, double* position, double* rotation,
              Frame* frames, Column* columns, Lanes& cost) {
  const std::size_t n_q = layout.n_q;
  const std::size_t n_x = layout.n_x;
  const std::size_t size = ik_normal_size(m);
  for (std::size_t i = 0; i < n_x; ++i) at(normal, i) = Lanes{};
  for (std::size_t i = layout.shared; i < size; ++i) at(normal, i) = Lanes{};
  const Lanes rad = all(m.length);
  cost = Lanes{};
  for (int goal = 0; goal < m.n_goals; ++goal) {
    const auto g = static_cast<std::size_t>(goal);
    const IkTarget& target = m.targets[goal];
    double* q = reinterpret_cast<double*>(&at(v, n_x + g * n_q));
    const Frame tip = walk(m, v, q, frames);
    columns_of(m, frames, tip.p, columns);

    Vec3 p{tip.p.x - target.position[0], tip.p.y - target.position[1], tip.p.z - target.position[2]};
    const double* N = target.rotation;
    const Vec3 n_x_axis{all(N[0]), all(N[3]), all(N[6])};
    const Vec3 n_y_axis{all(N[1]), all(N[4]), all(N[7])};
    const Vec3 n_z_axis{all(N[2]), all(N[5]), all(N[8])};
    Vec3 w = (cross(n_x_axis, tip.x) + cross(n_y_axis, tip.y) + cross(n_z_axis, tip.z)) * all(0.5);
    Lanes turned = 1.5 - 0.5 * (dot(n_x_axis, tip.x) + dot(n_y_axis, tip.y) + dot(n_z_axis, tip.z));
    if (!target.whole_position) {
      as_rows(target.R_TW, target, 0, p);
      for (std::size_t c = 0; c < n_q + n_x; ++c) columns[c].p = counting(target.R_TW, p, columns[c].p);
    }
    if (!target.whole_rotation) {
      as_rows(target.R_SW, target, 3, w);
      for (std::size_t c = 0; c < n_q + n_x; ++c) columns[c].w = counting(target.R_SW, w, columns[c].w);
      turned = 0.5 * dot(w, w);
    }
    const Lanes distance = dot(p, p);
    at(position, g) = distance;
    at(rotation, g) = turned;
    cost += 0.5 * distance + rad * rad * turned;
    w = w * rad;
    for (std::size_t c = 0; c < n_q + n_x; ++c) columns[c].w = columns[c].w * rad;

    double* joints = reinterpret_cast<double*>(&at(normal, layout.joints(g)));
    double* coupling = reinterpret_cast<double*>(&at(normal, layout.coupling(g)));
    double* shared = reinterpret_cast<double*>(&at(normal, layout.shared));
    for (std::size_t i = 0; i < n_q; ++i) {
      const Column& a = columns[i];
      at(normal, n_x + g * n_q + i) = dot(a.p, p) + dot(a.w, w);
      for (std::size_t k = 0; k <= i; ++k) {
        at(joints, triangle_at(i, k)) = dot(a.p, columns[k].p) + dot(a.w, columns[k].w);
      }
      for (std::size_t k = 0; k < n_x; ++k) {
        at(coupling, i * n_x + k) = dot(a.p, columns[n_q + k].p) + dot(a.w, columns[n_q + k].w);
      }
    }
    for (std::size_t i = 0; i < n_x; ++i) {
      const Column& a = columns[n_q + i];
      at(normal, i) += dot(a.p, p) + dot(a.w, w);
      for (std::size_t k = 0; k <= i; ++k) {
        at(shared, triangle_at(i, k)) += dot(a.p, columns[n_q + k].p) + dot(a.w, columns[n_q + k].w);
      }
    }
  }
}

// The factors L and 1 / D of a lower triangle [n], A = L D L^T, in place: 1 / D on the diagonal.
inline void factor(double* A, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      Lanes sum = at(A, triangle_at(i, j));
      for (std::size_t k = 0; k < j; ++k) sum -= at(A, triangle_at(i, k)) * at(A, triangle_at(j, k));
      at(A, triangle_at(i, j)) = sum;  // of L D; of L itself once the row is done
    }
    Lanes d = at(A, triangle_at(i, i));
    for (std::size_t k = 0; k < i; ++k) {
      const Lanes scaled = at(A, triangle_at(i, k));
      at(A, triangle_at(i, k)) = scaled * at(A, triangle_at(k, k));
      d -= scaled * at(A, triangle_at(i, k));
    }
    constexpr double kTiny = 1e-30;  // rounding may leave nothing of a damped diagonal
    at(A, triangle_at(i, i)) = 1.0 / greatest(d, all(kTiny));
  }
}

// y = L^-1 b for columns of `width` numbers side by side: b[row * width + column], in place.
inline void solve_forward(double* L, std::size_t n, double* b, std::size_t width) {
  for (std::size_t i = 1; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Lanes l = at(L, triangle_at(i, k));
      for (std::size_t c = 0; c < width; ++c) at(b, i * width + c) -= l * at(b, k * width + c);
    }
  }
}

// x = L^-T y, in place.
inline void solve_backward(double* L, std::size_t n, double* y) {
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) at(y, i) -= at(L, triangle_at(k, i)) * at(y, k);
  }
}

// A triangle with damped diagonal, rows and columns of held variables replaced by those of the identity. `free`: 1
// where a variable may move, else 0.
inline void damp(double* A, double* free, std::size_t n, Lanes damping, double* result) {
  // Directions that hardly matter would run away: none counts as stiffer than [m^2 per rad^2 or 1].
  constexpr double kLeastStiffness = 1e-3;
  for (std::size_t i = 0; i < n; ++i) {
    const Lanes f = at(free, i);
    for (std::size_t k = 0; k < i; ++k) at(result, triangle_at(i, k)) = f * at(free, k) * at(A, triangle_at(i, k));
    const Lanes a = at(A, triangle_at(i, i));
    at(result, triangle_at(i, i)) = f * (a + damping * greatest(a, all(kLeastStiffness))) + (1.0 - f);
  }
}

// The damped Gauss-Newton step from `v`. The normal equations have the shape of an arrow: a block per goal, coupled by
// the parameters alone, which are solved for first (their Schur complement).
void gauss_newton_step(const IkModel& m, const Layout& layout, double* normal, double* free, Lanes damping,
                       double* factored, double* step) {
  const std::size_t n_q = layout.n_q;
  const std::size_t n_x = layout.n_x;
  double* shared = reinterpret_cast<double*>(&at(factored, layout.shared));
  const auto n = static_cast<std::size_t>(ik_variables(m));
  for (std::size_t i = 0; i < n; ++i) at(step, i) = -at(free, i) * at(normal, i);
  damp(reinterpret_cast<double*>(&at(normal, layout.shared)), free, n_x, damping, shared);
  for (std::size_t g = 0; g < static_cast<std::size_t>(m.n_goals); ++g) {
    double* L = reinterpret_cast<double*>(&at(factored, layout.joints(g)));
    double* Y = reinterpret_cast<double*>(&at(factored, layout.coupling(g)));
    double* free_q = reinterpret_cast<double*>(&at(free, n_x + g * n_q));
    double* z = reinterpret_cast<double*>(&at(step, n_x + g * n_q));
    damp(reinterpret_cast<double*>(&at(normal, layout.joints(g))), free_q, n_q, damping, L);
    factor(L, n_q);
    for (std::size_t i = 0; i < n_q; ++i) {
      for (std::size_t k = 0; k < n_x; ++k) {
        at(Y, i * n_x + k) = at(free_q, i) * at(free, k) * at(normal, layout.coupling(g) + i * n_x + k);
      }
    }
    solve_forward(L, n_q, Y, n_x);
    solve_forward(L, n_q, z, 1);
    for (std::size_t i = 0; i < n_q; ++i) {
      const Lanes inverse = at(L, triangle_at(i, i));
      for (std::size_t k = 0; k < n_x; ++k) {
        const Lanes scaled = at(Y, i * n_x + k) * inverse;
        at(step, k) -= scaled * at(z, i);
        for (std::size_t l = 0; l <= k; ++l) at(shared, triangle_at(k, l)) -= scaled * at(Y, i * n_x + l);
      }
    }
  }
  factor(shared, n_x);
  solve_forward(shared, n_x, step, 1);
  for (std::size_t i = 0; i < n_x; ++i) at(step, i) *= at(shared, triangle_at(i, i));
  solve_backward(shared, n_x, step);
  for (std::size_t g = 0; g < static_cast<std::size_t>(m.n_goals); ++g) {
    double* L = reinterpret_cast<double*>(&at(factored, layout.joints(g)));
    double* Y = reinterpret_cast<double*>(&at(factored, layout.coupling(g)));
    double* z = reinterpret_cast<double*>(&at(step, n_x + g * n_q));
    for (std::size_t i = 0; i < n_q; ++i) {
      for (std::size_t k = 0; k < n_x; ++k) at(z, i) -= at(Y, i * n_x + k) * at(step, k);
      at(z, i) *= at(L, triangle_at(i, i));
    }
    solve_backward(L, n_q, z);
  }
}

// Levenberg-Marquardt within bounds: variables that stand at a bound and are pushed outwards are held, the others
// stepped and cut off at their bounds.
void step(const IkModel& m, const IkLanes& lanes) {
  constexpr double kEasier = 0.3;  // of the damping after a step that was taken; arbitrary, as below
  constexpr double kHarder = 5.0;
  constexpr double kLeastDamping = 1e-7;
  const Layout layout{m};
  const auto n = static_cast<std::size_t>(ik_variables(m));
  const auto n_goals = static_cast<std::size_t>(m.n_goals);
  const std::size_t size = ik_normal_size(m);
  double* next = lanes.work;
  const auto take = [&](std::size_t vectors) {
    double* const here = next;
    next += vectors * kIkLanes;
    return here;
  };
  double* const free = take(n);
  double* const trial = take(n);
  double* const towards = take(n);
  double* const trial_normal = take(size);
  double* const factored = take(size);
  double* const trial_position = take(n_goals);
  double* const trial_rotation = take(n_goals);
  auto* const columns = reinterpret_cast<Column*>(take(6 * (layout.n_q + layout.n_x)));
  auto* const frames = reinterpret_cast<Frame*>(take(12 * static_cast<std::size_t>(m.n_links + 1)));

  const Lanes cost = at(lanes.cost, 0);
  const Lanes damping = at(lanes.damping, 0);
  const Mask known = cost < __builtin_inf();
  for (std::size_t i = 0; i < n; ++i) {
    const Lanes v = at(lanes.v, i);
    const Lanes g = at(lanes.normal, i);
    const Mask held = ((v <= m.lower[i]) & (g > 0.0)) | ((v >= m.upper[i]) & (g < 0.0));
    at(free, i) = held ? Lanes{} : all(1.0);
  }
  gauss_newton_step(m, layout, lanes.normal, free, damping, factored, towards);
  for (std::size_t i = 0; i < n; ++i) {
    const Lanes v = at(lanes.v, i);
    const Lanes there = least(greatest(v + at(towards, i), all(m.lower[i])), all(m.upper[i]));
    at(trial, i) = known ? there : v;
  }
  Lanes trial_cost;
  evaluate(m, layout, trial, trial_normal, trial_position, trial_rotation, frames, columns, trial_cost);

  const Mask better = trial_cost < cost;
  const auto keep = [&](double* here, double* there, std::size_t vectors) {
    for (std::size_t i = 0; i < vectors; ++i) at(here, i) = better ? at(there, i) : at(here, i);
  };
  keep(lanes.v, trial, n);
  keep(lanes.normal, trial_normal, size);
  keep(lanes.position, trial_position, n_goals);
  keep(lanes.rotation, trial_rotation, n_goals);
  at(lanes.cost, 0) = better ? trial_cost : cost;
  const Lanes easier = known ? greatest(damping * kEasier, all(kLeastDamping)) : damping;
  at(lanes.damping, 0) = better ? easier : damping * kHarder;
}

}  // namespace

const IkKernel kTable{step};

}  // namespace modsearch::detail
