#pragma once

#include <functional>
#include <string>

namespace modsearch::detail {

/// What `work` gives, computed by a copy of this process: for libraries that may crash, run on for ever or take all
/// memory on files that somebody else made. What `work` changes is lost but for what it returns.
/// Throws std::runtime_error: what `work` throws, or how the process ended if it gave nothing (a signal, a minute of
/// processor time, 4 GiB beyond what this process has), or that there was none to be had.
[[nodiscard]] std::string in_child_process(const std::function<std::string()>& work);

}  // namespace modsearch::detail
