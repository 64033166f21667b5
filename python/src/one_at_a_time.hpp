#pragma once

#include <atomic>
#include <stdexcept>
#include <string>

namespace modsearch::python {

/// A door that lets one caller in and refuses all others: two threads of Python that use one object at once would
/// otherwise meet in C++, where nothing keeps them apart.
class OneAtATime {
 public:
  class Inside {
   public:
    explicit Inside(OneAtATime& door, const char* what) : door_{door} {
      if (door_.taken_.test_and_set()) throw std::runtime_error(std::string{what} + " is in use by another thread");
    }
    ~Inside() { door_.taken_.clear(); }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

   private:
    OneAtATime& door_;
  };

 private:
  std::atomic_flag taken_;
};

}  // namespace modsearch::python
