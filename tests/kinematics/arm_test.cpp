#include <gmock/gmock.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <limits>
#include <modsearch/kinematics/arm.hpp>
#include <numbers>
#include <random>

namespace modsearch {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr int kParameters = 5;

double uniform(std::mt19937& generator, double lower, double upper) {
  return std::uniform_real_distribution<double>{lower, upper}(generator);
}

Eigen::VectorXd random_vector(Eigen::Index size, std::mt19937& generator) {
  Eigen::VectorXd result(size);
  for (double& entry : result) entry = uniform(generator, -1, 1);
  return result;
}

// A random rotation (one in three: none, so that the shortcut for it is met too) and a translation affine in up to
// three of the parameters.
AffinePose random_pose(std::mt19937& generator) {
  AffineVector p{Eigen::Vector3d{random_vector(3, generator)}};
  const int first = static_cast<int>(generator() % kParameters);
  for (int k = 0; k < static_cast<int>(generator() % 4); ++k) {
    p.terms.push_back({(first + k) % kParameters, random_vector(3, generator)});
  }
  const Eigen::Quaterniond rotation{Eigen::Vector4d{random_vector(4, generator)}.normalized()};
  return {generator() % 3 == 0 ? Eigen::Matrix3d::Identity().eval() : rotation.toRotationMatrix(), p};
}

// What a random chain is made of, for a second implementation to build it from.
struct Recipe {
  struct Step {
    bool moves = false;  // a joint, else a fixed transform
    JointType type = JointType::kRevolute;
    AffinePose X;
    AffineScalar twist;  // about z, before X
  };
  std::vector<Step> steps;

  explicit Recipe(std::mt19937& generator, bool twisted = false) {
    const int n = static_cast<int>(generator() % 12);
    for (int i = 0; i < n; ++i) {
      constexpr std::array kTypes{JointType::kRevolute, JointType::kPrismatic, JointType::kContinuous};
      if (generator() % 2 == 0) {
        steps.push_back({true, kTypes[generator() % 3], {}, {}});
      } else {
        steps.push_back({false, {}, random_pose(generator), {}});
      }
      if (twisted && generator() % 2 == 0) {
        const int parameter = static_cast<int>(generator() % kParameters);
        steps.back().moves = false;
        steps.back().twist = AffineScalar::of_parameter(parameter, uniform(generator, -2, 2), uniform(generator, -1, 1));
      }
    }
  }

  [[nodiscard]] Chain chain() const {
    ChainBuilder builder{kParameters};
    for (const Step& step : steps) {
      if (step.moves) {
        const double limit = step.type == JointType::kContinuous ? std::numeric_limits<double>::infinity() : 3.0;
        builder.joint({.name = "j", .type = step.type, .lower = -limit, .upper = limit});
      } else {
        builder.move(ParametricPose::turn(step.twist) * step.X);
      }
    }
    return builder.build();
  }

  [[nodiscard]] KDL::Chain kdl(const Eigen::VectorXd& x) const {
    KDL::Chain chain;
    for (const Step& step : steps) {
      if (step.moves) {
        const auto type = step.type == JointType::kPrismatic ? KDL::Joint::TransZ : KDL::Joint::RotZ;
        chain.addSegment(KDL::Segment{KDL::Joint{type}});
      } else {
        if (!step.twist.terms.empty()) {
          const KDL::Frame twist{KDL::Rotation::RotZ(step.twist.at(x))};
          chain.addSegment(KDL::Segment{KDL::Joint{KDL::Joint::None}, twist});
        }
        const Eigen::Matrix3d& R = step.X.rotation;
        Eigen::Vector3d p = step.X.translation.offset;
        for (const AffineVector::Term& term : step.X.translation.terms) p += x[term.parameter] * term.direction;
        chain.addSegment(KDL::Segment{
            KDL::Joint{KDL::Joint::None},
            KDL::Frame{KDL::Rotation{R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)},
                       KDL::Vector{p.x(), p.y(), p.z()}}});
      }
    }
    return chain;
  }
};

KDL::JntArray jnt_array(const Eigen::VectorXd& q) {
  KDL::JntArray result{static_cast<unsigned>(q.size())};
  result.data = q;
  return result;
}

TEST(Arm, ForwardKinematicsAgreesWithKdlOnAThousandRandomChains) {
  std::mt19937 generator{1};
  for (int i = 0; i < 1000; ++i) {
    const Recipe recipe{generator};
    const Chain chain = recipe.chain();
    const Eigen::VectorXd x = random_vector(kParameters, generator);
    const Eigen::VectorXd q = 3.0 * random_vector(chain.n_joints(), generator);
    const Posture posture = chain.at(x).forward(q);

    const KDL::Chain kdl_chain = recipe.kdl(x);
    KDL::ChainFkSolverPos_recursive solver{kdl_chain};
    unsigned n_segments = 0;  // KDL gives the pose after so many segments
    std::size_t frame = 0;
    const auto expect_pose = [&](const Eigen::Isometry3d& X) {
      KDL::Frame expected;
      solver.JntToCart(jnt_array(q), expected, static_cast<int>(n_segments));
      for (int row = 0; row < 3; ++row) {
        ASSERT_NEAR(X.translation()[row], expected.p[row], 1e-12) << "chain " << i;
        for (int column = 0; column < 3; ++column) ASSERT_NEAR(X.linear()(row, column), expected.M(row, column), 1e-12);
      }
    };
    for (const Recipe::Step& step : recipe.steps) {
      ++n_segments;
      if (step.moves) expect_pose(posture.frames[++frame]);
    }
    expect_pose(posture.tip);
  }
}

TEST(Arm, TipJacobianAgreesWithKdlOnAThousandRandomChains) {
  std::mt19937 generator{2};
  for (int i = 0; i < 1000; ++i) {
    const Recipe recipe{generator};
    const Chain chain = recipe.chain();
    const Eigen::VectorXd x = random_vector(kParameters, generator);
    const Eigen::VectorXd q = 3.0 * random_vector(chain.n_joints(), generator);
    const Arm arm = chain.at(x);
    const KDL::Chain kdl_chain = recipe.kdl(x);
    KDL::ChainJntToJacSolver solver{kdl_chain};
    KDL::Jacobian expected{static_cast<unsigned>(chain.n_joints())};
    solver.JntToJac(jnt_array(q), expected);
    const auto J = arm.tip_jacobian_q(arm.forward(q));
    ASSERT_LE((J - expected.data).norm(), 1e-12) << "chain " << i;  // 0 without joints
  }
}

// Central differences with this step are exact to about its square times the third derivative (lengths of some metres).
constexpr double kStep = 1e-5;
constexpr double kStepError = 1e-8;

TEST(Arm, JacobiansOfPointsOnEveryFrameAgreeWithCentralDifferences) {
  std::mt19937 generator{3};
  for (int i = 0; i < 100; ++i) {
    const Chain chain = Recipe{generator}.chain();
    const Eigen::VectorXd x = random_vector(kParameters, generator);
    const Eigen::VectorXd q = 3.0 * random_vector(chain.n_joints(), generator);
    const Arm arm = chain.at(x);
    const Posture posture = arm.forward(q);
    const Eigen::Vector3d p_F = random_vector(3, generator);
    for (int frame = 0; frame <= chain.n_joints(); ++frame) {
      const auto f = static_cast<std::size_t>(frame);
      const Eigen::Matrix3Xd J = arm.point_jacobian_q(posture, frame, posture.frames[f] * p_F);
      ASSERT_EQ(J.cols(), chain.n_joints());
      for (int j = 0; j < chain.n_joints(); ++j) {
        const Eigen::VectorXd h = kStep * Eigen::VectorXd::Unit(q.size(), j);
        const Eigen::Vector3d expected =
            (arm.forward(q + h).frames[f] * p_F - arm.forward(q - h).frames[f] * p_F) / (2.0 * kStep);
        ASSERT_LE((J.col(j) - expected).norm(), kStepError);
      }
      const Eigen::Matrix3Xd J_x =
          arm.point_jacobian_x(posture, frame, posture.frames[static_cast<std::size_t>(frame)].translation());
      for (int k = 0; k < kParameters; ++k) {
        const Eigen::VectorXd h = Eigen::VectorXd::Unit(kParameters, k);  // affine: any step is exact
        const Eigen::Vector3d expected =
            (chain.at(x + h).forward(q).frames[f].translation() - chain.at(x - h).forward(q).frames[f].translation()) /
            2.0;
        ASSERT_LE((J_x.col(k) - expected).norm(), 1e-13);
      }
    }
  }
}

TEST(Arm, TipJacobianInTheParametersAndHessianAgreeWithDifferences) {
  std::mt19937 generator{4};
  for (int i = 0; i < 200; ++i) {
    const Chain chain = Recipe{generator}.chain();
    const int n = chain.n_joints();
    const Eigen::VectorXd x = random_vector(kParameters, generator);
    const Eigen::VectorXd q = 3.0 * random_vector(n, generator);
    const Eigen::Vector3d y = random_vector(3, generator);
    const Arm arm = chain.at(x);
    const Posture posture = arm.forward(q);

    const Eigen::Matrix3Xd J_x = arm.tip_jacobian_x(posture).topRows<3>();
    for (int k = 0; k < kParameters; ++k) {
      const Arm longer = chain.at(x + Eigen::VectorXd::Unit(kParameters, k));
      ASSERT_LE((J_x.col(k) - (longer.forward(q).tip.translation() - posture.tip.translation())).norm(), 1e-12);
    }

    const auto gradient = [&](const Eigen::VectorXd& at_x, const Eigen::VectorXd& at_q) {
      const Arm moved = chain.at(at_x);
      const Posture there = moved.forward(at_q);
      Eigen::VectorXd g(kParameters + n);
      g << moved.tip_jacobian_x(there).topRows<3>().transpose() * y, moved.tip_jacobian_q(there).topRows<3>().transpose() * y;
      return g;
    };
    const Eigen::MatrixXd H = arm.tip_hessian(posture, y);
    ASSERT_EQ(H.topLeftCorner(kParameters, kParameters), Eigen::MatrixXd::Zero(kParameters, kParameters));
    ASSERT_EQ(H, H.transpose());
    for (int c = 0; c < kParameters + n; ++c) {
      Eigen::VectorXd h_x = Eigen::VectorXd::Zero(kParameters);
      Eigen::VectorXd h_q = Eigen::VectorXd::Zero(n);
      (c < kParameters ? h_x[c] : h_q[c - kParameters]) = kStep;
      const Eigen::VectorXd expected = (gradient(x + h_x, q + h_q) - gradient(x - h_x, q - h_q)) / (2.0 * kStep);
      ASSERT_LE((H.col(c) - expected).cwiseAbs().maxCoeff(), kStepError) << "chain " << i << " column " << c;
    }
  }
}

TEST(Arm, TipIsAffineInTheParameters) {
  std::mt19937 generator{5};
  for (int i = 0; i < 200; ++i) {
    const Chain chain = Recipe{generator}.chain();
    const Eigen::VectorXd q = 3.0 * random_vector(chain.n_joints(), generator);
    const Eigen::VectorXd x = 2.0 * random_vector(kParameters, generator);
    // p(x) = p(0) + sum_i x_i (p(e_i) - p(0))
    const Eigen::Isometry3d at_zero = chain.at(Eigen::VectorXd::Zero(kParameters)).forward(q).tip;
    Eigen::Vector3d expected = at_zero.translation();
    for (int k = 0; k < kParameters; ++k) {
      const Eigen::Isometry3d at_unit = chain.at(Eigen::VectorXd::Unit(kParameters, k)).forward(q).tip;
      expected += x[k] * (at_unit.translation() - at_zero.translation());
      ASSERT_EQ(at_unit.linear(), at_zero.linear());
    }
    ASSERT_LE((chain.at(x).forward(q).tip.translation() - expected).norm(), 1e-13 * (1.0 + 20.0));
  }
}

TEST(Arm, WithTwistsAgreesWithKdlOnAThousandRandomChains) {
  std::mt19937 generator{21};
  for (int i = 0; i < 1000; ++i) {
    const Recipe recipe{generator, true};
    const Chain chain = recipe.chain();
    const Eigen::VectorXd x = random_vector(kParameters, generator);
    const Eigen::VectorXd q = 3.0 * random_vector(chain.n_joints(), generator);
    const KDL::Chain kdl_chain = recipe.kdl(x);
    KDL::ChainFkSolverPos_recursive solver{kdl_chain};
    KDL::Frame expected;
    solver.JntToCart(jnt_array(q), expected);
    const Eigen::Isometry3d tip = chain.at(x).forward(q).tip;
    for (int r = 0; r < 3; ++r) {
      ASSERT_NEAR(tip.translation()[r], expected.p[r], 1e-12);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(tip.linear()(r, c), expected.M(r, c), 1e-12);
    }
  }
}

TEST(Arm, DerivativesInTwistsAgreeWithCentralDifferences) {
  std::mt19937 generator{22};
  for (int i = 0; i < 200; ++i) {
    const Chain chain = Recipe{generator, true}.chain();
    const int n = chain.n_joints();
    const Eigen::VectorXd x = random_vector(kParameters, generator);
    const Eigen::VectorXd q = 3.0 * random_vector(n, generator);
    const Eigen::Vector3d y = random_vector(3, generator);
    const Arm arm = chain.at(x);
    const Posture posture = arm.forward(q);

    // A point that lies off the origin of its frame feels the frame turn.
    const Eigen::Vector3d p_F = random_vector(3, generator);
    for (int frame = 0; frame <= n + 1; ++frame) {
      const auto point = [&](const Posture& at) -> Eigen::Vector3d {
        return (frame <= n ? at.frames[static_cast<std::size_t>(frame)] : at.tip) * p_F;
      };
      const Eigen::Matrix3Xd J = arm.point_jacobian_x(posture, frame, point(posture));
      for (int k = 0; k < kParameters; ++k) {
        const Eigen::VectorXd h = kStep * Eigen::VectorXd::Unit(kParameters, k);
        const Eigen::Vector3d expected =
            (point(chain.at(x + h).forward(q)) - point(chain.at(x - h).forward(q))) / (2.0 * kStep);
        ASSERT_LE((J.col(k) - expected).norm(), kStepError) << "chain " << i << " frame " << frame;
      }
    }

    const Eigen::Matrix<double, 6, Eigen::Dynamic> J_x = arm.tip_jacobian_x(posture);
    for (int k = 0; k < kParameters; ++k) {
      const Eigen::VectorXd h = kStep * Eigen::VectorXd::Unit(kParameters, k);
      const Eigen::Matrix3d ahead = chain.at(x + h).forward(q).tip.linear();
      const Eigen::Matrix3d behind = chain.at(x - h).forward(q).tip.linear();
      // dR = [w] R, so the skew part of dR R^T is w.
      const Eigen::Matrix3d W = (ahead - behind) / (2.0 * kStep) * posture.tip.linear().transpose();
      ASSERT_LE((J_x.bottomRows<3>().col(k) - Eigen::Vector3d{W(2, 1), W(0, 2), W(1, 0)}).norm(), kStepError);
    }

    const auto gradient = [&](const Eigen::VectorXd& at_x, const Eigen::VectorXd& at_q) {
      const Arm moved = chain.at(at_x);
      const Posture there = moved.forward(at_q);
      Eigen::VectorXd g(kParameters + n);
      g << moved.tip_jacobian_x(there).topRows<3>().transpose() * y,
          moved.tip_jacobian_q(there).topRows<3>().transpose() * y;
      return g;
    };
    const Eigen::MatrixXd H = arm.tip_hessian(posture, y);
    for (int c = 0; c < kParameters + n; ++c) {
      Eigen::VectorXd h_x = Eigen::VectorXd::Zero(kParameters);
      Eigen::VectorXd h_q = Eigen::VectorXd::Zero(n);
      (c < kParameters ? h_x[c] : h_q[c - kParameters]) = kStep;
      const Eigen::VectorXd expected = (gradient(x + h_x, q + h_q) - gradient(x - h_x, q - h_q)) / (2.0 * kStep);
      ASSERT_LE((H.col(c) - expected).cwiseAbs().maxCoeff(), 4.0 * kStepError) << "chain " << i << " column " << c;
    }
  }
}

TEST(Arm, SettingParametersEqualsBuildingAnew) {
  std::mt19937 generator{6};
  const Chain chain = Recipe{generator}.chain();
  Arm arm = chain.at(Eigen::VectorXd::Zero(kParameters));
  const Eigen::VectorXd x = random_vector(kParameters, generator);
  arm.set_parameters(x);
  const Eigen::VectorXd q = random_vector(chain.n_joints(), generator);
  EXPECT_EQ(arm.forward(q).tip.matrix(), chain.at(x).forward(q).tip.matrix());
  EXPECT_EQ(arm.parameters(), x);
}

TEST(Arm, NoPostureGoesBeyondItsReach) {
  std::mt19937 generator{7};
  for (int i = 0; i < 200; ++i) {
    const Chain chain = Recipe{generator}.chain();
    const Arm arm = chain.at(random_vector(kParameters, generator));
    const Eigen::Vector3d origin = arm.segment(0).translation();  // of joint 0 before it moves, or the tip
    for (int k = 0; k < 20; ++k) {
      const Eigen::VectorXd q = 3.0 * random_vector(chain.n_joints(), generator);
      const double away = chain.n_joints() == 0 ? arm.forward(q).tip.translation().norm()
                                                : (arm.forward(q).tip.translation() - origin).norm();
      ASSERT_LE(away, arm.reach() + 1e-12);
    }
  }
}

TEST(Arm, PlacesItsShapesAndTheirSizes) {
  // A cylinder of length x0 from the base up, and one of length x1 beyond a joint about the horizontal x axis.
  ChainBuilder builder{2};
  const auto rod = [&](int parameter) {
    const AffinePose middle{Eigen::Matrix3d::Identity(), {0.0, 0.0, AffineScalar::of_parameter(parameter, 0.5)}};
    const AffineShape shape{AffineShape::Kind::kCylinder, {0.05, AffineScalar::of_parameter(parameter)}, nullptr};
    builder.body("rod", 0, AffineScalar::of_parameter(parameter, 2.0), {{shape, middle}});
    builder.move(AffinePose{Eigen::Matrix3d::Identity(), {0.0, 0.0, AffineScalar::of_parameter(parameter)}});
  };
  const Eigen::Isometry3d to_x{Eigen::AngleAxisd{kPi / 2, Eigen::Vector3d::UnitY()}};
  rod(0);
  builder.move(to_x).joint({.name = "elbow", .lower = -kPi, .upper = kPi}).move(to_x.inverse());
  rod(1);
  const Chain chain = builder.build();
  const Arm arm = chain.at(Eigen::Vector2d{0.8, 1.2});

  ASSERT_EQ(arm.geometries().size(), 2u);
  EXPECT_EQ(std::get<Cylinder>(arm.geometries()[1].shape).length, 1.2);
  EXPECT_EQ(arm.geometries()[1].frame, 1);
  EXPECT_DOUBLE_EQ(arm.mass(), 2.0 * 0.8 + 2.0 * 1.2);
  // The elbow at a right angle: the second rod's centre is 0.6 m along -y from (0, 0, 0.8).
  const Posture posture = arm.forward(Eigen::VectorXd::Constant(1, kPi / 2));
  const Eigen::Vector3d centre = (posture.frames[1] * arm.geometries()[1].X_FG).translation();
  EXPECT_LE((centre - Eigen::Vector3d(0, -0.6, 0.8)).norm(), 1e-15);
  EXPECT_LE((posture.tip.translation() - Eigen::Vector3d(0, -1.2, 0.8)).norm(), 1e-15);
}

TEST(Arm, RefusesWrongSizesAndNumbersThatAreNone) {
  ChainBuilder builder{1};
  const AffineShape shape{AffineShape::Kind::kCylinder, {0.05, AffineScalar::of_parameter(0)}, nullptr};
  builder.joint({.name = "base", .lower = -1, .upper = 1});
  builder.body("tube", 0, 1.0, {{shape, {}}});
  const Chain chain = builder.build();
  const auto at = [&](double length) {
    return [&chain, length] { (void)chain.at(Eigen::VectorXd::Constant(1, length)); };
  };
  EXPECT_NO_THROW(at(0.0)());
  EXPECT_THAT(at(-0.1), ThrowsMessage<std::invalid_argument>(HasSubstr("'tube'")));
  EXPECT_THAT(at(std::nan("")), ThrowsMessage<std::invalid_argument>(HasSubstr("nan")));
  EXPECT_THAT(at(std::numeric_limits<double>::infinity()), ThrowsMessage<std::invalid_argument>(HasSubstr("inf")));
  EXPECT_THAT([&] { (void)chain.at(Eigen::VectorXd::Zero(2)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("2 parameters given, the chain has 1")));
  EXPECT_THAT([&] { (void)chain.at(Eigen::VectorXd::Ones(1)).forward(Eigen::VectorXd::Zero(3)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("3 joint values given, the chain has 1")));
}

}  // namespace
}  // namespace modsearch
