#pragma once

#include <unistd.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace modsearch::test {

/// A locale whose decimal point is a comma, for a while: what a program that talks to people has set. Where the machine
/// has none, one is made of the sources that come with its C library.
class GermanLocale {
 public:
  GermanLocale()
      : folder_{std::filesystem::temp_directory_path() / ("modsearch_locale_" + std::to_string(::getpid()))} {
    if (set()) return;
    std::filesystem::create_directories(folder_);
    const std::string made = (folder_ / "de_DE.UTF-8").string();
    if (std::system(("localedef -i de_DE -f UTF-8 '" + made + "' >/dev/null 2>&1").c_str()) != 0) return;
    ::setenv("LOCPATH", folder_.c_str(), 1);
    static_cast<void>(set());
  }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;
  ~GermanLocale() {
    std::setlocale(LC_ALL, "C");
    ::unsetenv("LOCPATH");
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  /// Whether there is one: printf then writes 1,5.
  [[nodiscard]] static bool is_set() {
    char text[8];
    std::snprintf(text, sizeof text, "%.1f", 1.5);
    return std::string{text} == "1,5";
  }

 private:
  static bool set() { return std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr; }

  std::filesystem::path folder_;
};

}  // namespace modsearch::test
