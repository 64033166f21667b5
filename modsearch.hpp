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
#include <modsearch/problem/problem_source.hpp>
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

#include <modsearch/rl/acting.hpp>
#include <modsearch/rl/action_model.hpp>
#include <modsearch/rl/action_values.hpp>
#include <modsearch/rl/actor_gradient.hpp>
#include <modsearch/rl/adam.hpp>
#include <modsearch/rl/agent.hpp>
#include <modsearch/rl/agent_options.hpp>
#include <modsearch/rl/agents.hpp>
#include <modsearch/rl/archive.hpp>
#include <modsearch/rl/design_environment.hpp>
#include <modsearch/rl/design_model.hpp>
#include <modsearch/rl/dqn.hpp>
#include <modsearch/rl/elite.hpp>
#include <modsearch/rl/environment.hpp>
#include <modsearch/rl/event_file.hpp>
#include <modsearch/rl/exploration.hpp>
#include <modsearch/rl/float_buffer.hpp>
#include <modsearch/rl/float_kernels.hpp>
#include <modsearch/rl/hybrid_space.hpp>
#include <modsearch/rl/learner.hpp>
#include <modsearch/rl/mlp.hpp>
#include <modsearch/rl/network.hpp>
#include <modsearch/rl/observation_encoder.hpp>
#include <modsearch/rl/paddpg.hpp>
#include <modsearch/rl/parameter_actor.hpp>
#include <modsearch/rl/pdqn.hpp>
#include <modsearch/rl/policy_file.hpp>
#include <modsearch/rl/polish.hpp>
#include <modsearch/rl/replay.hpp>
#include <modsearch/rl/returns.hpp>
#include <modsearch/rl/saved_policy.hpp>
#include <modsearch/rl/settings.hpp>
#include <modsearch/rl/training.hpp>
#include <modsearch/rl/training_csv.hpp>

#include <modsearch/study/environment_page.hpp>
#include <modsearch/study/journal.hpp>
#include <modsearch/study/page.hpp>
#include <modsearch/study/records.hpp>
#include <modsearch/study/solution_page.hpp>
