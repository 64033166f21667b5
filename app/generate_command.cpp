#include <modsearch/problem/whitman.hpp>

#include "app/commands.hpp"
#include "app/output_internal.hpp"

namespace modsearch::app {
Status generate(const GenerateArguments& arguments, const CommonArguments& common) {
  WhitmanTasks tasks{.goals = arguments.goals, .boxes = arguments.boxes};
  if (arguments.free_ends) tasks.free_ends = whitman_library();
  static_cast<void>(whitman_task(tasks, {}));  // says what is wrong before a folder is made
  const OutputLock lock = claim_folder(arguments.out);
  std::vector<std::string> written;
  for (int i = 0; i < arguments.count; ++i) {
    const std::string number = fmt::format("{:03}", i);
    const std::string task = fmt::format("task_{}.json", number);
    write_file(arguments.out / task,
               whitman_task(tasks, {.seed = arguments.seed, .index = static_cast<std::uint64_t>(i)}));
    write_file(arguments.out / fmt::format("problem_{}.json", number), whitman_problem(task));
    written.push_back(fmt::format("problem_{}.json", number));
  }
  if (common.json) {
    print({{"folder", arguments.out.string()}, {"problems", written}});
  } else {
    say("wrote        {} tasks and problems in {}\n", written.size(), arguments.out.string());
  }
  return Status::kSuccess;
}

}  // namespace modsearch::app
