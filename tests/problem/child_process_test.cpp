#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <modsearch/problem/child_process_internal.hpp>
#include <stdexcept>

namespace modsearch::detail {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(ChildProcess, GivesWhatTheWorkGives) {
  EXPECT_EQ(in_child_process([] { return std::string{}; }), "");
  const std::string large(1'000'000, 'x');  // more than a pipe holds
  EXPECT_EQ(in_child_process([&] { return large; }), large);
}

TEST(ChildProcess, KeepsChangesToItself) {
  int touched = 0;
  EXPECT_EQ(in_child_process([&] { return std::to_string(++touched); }), "1");
  EXPECT_EQ(touched, 0);
}

TEST(ChildProcess, PassesOnWhatTheWorkThrows) {
  EXPECT_THAT([] { static_cast<void>(in_child_process([]() -> std::string { throw std::out_of_range{"too far"}; })); },
              ThrowsMessage<std::runtime_error>("too far"));
}

TEST(ChildProcess, NamesTheSignalOfACrash) {
  const auto crash = []() -> std::string {
    std::raise(SIGSEGV);
    return "unreached";
  };
  EXPECT_THAT([&] { static_cast<void>(in_child_process(crash)); },
              ThrowsMessage<std::runtime_error>(HasSubstr("its reader ended with signal 11")));
}

TEST(ChildProcess, HandsOutNoMoreMemoryThanItsLimit) {
  const auto greedy = [] { return std::to_string(std::string(std::size_t{5} << 30U, 'x').size()); };
  EXPECT_THROW(static_cast<void>(in_child_process(greedy)), std::runtime_error);
}

}  // namespace
}  // namespace modsearch::detail
