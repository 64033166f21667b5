#pragma once

// Everything of modsearch that an application may use, floor by floor.

#include <modsearch/kinematics/affine.hpp>
#include <modsearch/kinematics/arm.hpp>
#include <modsearch/kinematics/bounding_capsule.hpp>
#include <modsearch/kinematics/chain.hpp>
#include <modsearch/kinematics/inverse_kinematics.hpp>
#include <modsearch/kinematics/low_discrepancy.hpp>
#include <modsearch/kinematics/path_planning.hpp>
#include <modsearch/kinematics/pose_region.hpp>
#include <modsearch/kinematics/scene.hpp>
#include <modsearch/kinematics/separation.hpp>
#include <modsearch/kinematics/shape.hpp>
#include <modsearch/kinematics/work.hpp>

#include <modsearch/problem/attempt.hpp>
#include <modsearch/problem/design.hpp>
#include <modsearch/problem/design_problem.hpp>
#include <modsearch/problem/files.hpp>
#include <modsearch/problem/module_library.hpp>
#include <modsearch/problem/reach_bound.hpp>
#include <modsearch/problem/rng.hpp>
#include <modsearch/problem/robot_problem.hpp>
#include <modsearch/problem/row_sink.hpp>
#include <modsearch/problem/scoring.hpp>
#include <modsearch/problem/smooth_program.hpp>
#include <modsearch/problem/task.hpp>
#include <modsearch/problem/task_program.hpp>

#include <modsearch/solvers/inner_solver.hpp>
#include <modsearch/solvers/meter.hpp>
#include <modsearch/solvers/solver.hpp>
#include <modsearch/solvers/verification.hpp>

#include <modsearch/baselines/auto_solver.hpp>
#include <modsearch/baselines/per_sequence.hpp>
#include <modsearch/baselines/random_search.hpp>
#include <modsearch/baselines/staged.hpp>
