#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <modsearch/problem/files.hpp>
#include <modsearch/rl/event_file.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <string>
#include <vector>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using test::text_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename T>
T number_at(std::string_view bytes, std::size_t position) {
  T number;
  EXPECT_LE(position + sizeof number, bytes.size());
  std::memcpy(&number, bytes.data() + position, sizeof number);
  return number;
}

std::uint32_t unmasked(std::uint32_t masked) {
  const std::uint32_t turned = masked - 0xA282EAD8U;
  return turned >> 17 | turned << 15;
}

/// The records of a TFRecord file, both checksums of each compared.
std::vector<std::string> records_of(std::string_view file) {
  std::vector<std::string> records;
  while (!file.empty()) {
    const auto size = number_at<std::uint64_t>(file, 0);
    EXPECT_EQ(unmasked(number_at<std::uint32_t>(file, 8)), crc32c(std::as_bytes(std::span{file.substr(0, 8)})));
    const std::string_view record = file.substr(12, size);
    EXPECT_EQ(record.size(), size);
    EXPECT_EQ(unmasked(number_at<std::uint32_t>(file, 12 + size)), crc32c(std::as_bytes(std::span{record})));
    records.emplace_back(record);
    file.remove_prefix(16 + size);
  }
  return records;
}

/// The fields of a protocol buffer, bytes as they are; numbers of variable length as eight bytes.
std::map<std::uint64_t, std::string> fields_of(std::string_view message) {
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const auto byte = static_cast<unsigned char>(message.at(0));
      message.remove_prefix(1);
      value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if (byte < 0x80) return value;
    }
  };
  std::map<std::uint64_t, std::string> fields;
  while (!message.empty()) {
    const std::uint64_t key = varint();
    std::string value;
    switch (key & 7) {
      case 0: {
        const std::uint64_t number = varint();
        value.assign(reinterpret_cast<const char*>(&number), sizeof number);
        break;
      }
      case 1:
        value = message.substr(0, 8);
        message.remove_prefix(8);
        break;
      case 2: {
        const std::uint64_t size = varint();
        value = message.substr(0, size);
        message.remove_prefix(size);
        break;
      }
      case 5:
        value = message.substr(0, 4);
        message.remove_prefix(4);
        break;
      default:
        ADD_FAILURE() << "wire type " << (key & 7);
        return fields;
    }
    EXPECT_TRUE(fields.emplace(key >> 3, value).second) << "field " << (key >> 3) << " twice";
  }
  return fields;
}

TEST(EventFile, IsNamedAsTensorBoardExpectsInADirectoryThatItMakes) {
  const TemporaryFolder folder;
  const EventFile file{folder.path() / "runs" / "one", 1'700'000'000.75};
  EXPECT_EQ(file.path(), folder.path() / "runs" / "one" / "events.out.tfevents.1700000000.modsearch");
}

TEST(EventFile, BeginsWithItsVersion) {
  const TemporaryFolder folder;
  const EventFile file{folder.path(), 1'700'000'000.75};
  const std::vector<std::string> records = records_of(text_of(file.path()));
  ASSERT_EQ(records.size(), 1U);
  const auto event = fields_of(records[0]);
  EXPECT_EQ(number_at<double>(event.at(1), 0), 1'700'000'000.75);
  EXPECT_EQ(event.at(3), "brain.Event:2");
}

TEST(EventFile, HoldsEveryScalarOnceItIsWritten) {
  const TemporaryFolder folder;
  EventFile file{folder.path(), 1'700'000'000.0};
  file.scalar("evaluation/return", 0, 0.284, 1'700'000'001.5);
  file.scalar("loss", 3'000'000'000, -1e-3, 1'700'000'002.0);
  file.scalar(std::string(300, 'x'), -1, std::numeric_limits<double>::infinity(), 1'700'000'003.0);
  const std::vector<std::string> records = records_of(text_of(file.path()));  // while the file is still open
  ASSERT_EQ(records.size(), 4U);
  const auto check = [&](std::size_t i, const std::string& tag, std::int64_t step, float value, double wall_time) {
    const auto event = fields_of(records[i]);
    EXPECT_EQ(event.size(), 3U);
    EXPECT_EQ(number_at<double>(event.at(1), 0), wall_time);
    EXPECT_EQ(number_at<std::int64_t>(event.at(2), 0), step);
    const auto entry = fields_of(fields_of(event.at(5)).at(1));
    EXPECT_EQ(entry.size(), 2U);
    EXPECT_EQ(entry.at(1), tag);
    EXPECT_EQ(number_at<float>(entry.at(2), 0), value);
  };
  check(1, "evaluation/return", 0, 0.284F, 1'700'000'001.5);
  check(2, "loss", 3'000'000'000, -1e-3F, 1'700'000'002.0);
  check(3, std::string(300, 'x'), -1, std::numeric_limits<float>::infinity(), 1'700'000'003.0);
}

// Worked out by hand from event.proto and the wire format.
TEST(EventFile, WritesTheBytesOfTheFormat) {
  const TemporaryFolder folder;
  EventFile file{folder.path(), 0.0};
  file.scalar("a", 300, 1.0, 2.0);
  using namespace std::string_literals;
  EXPECT_EQ(records_of(text_of(file.path()))[1],
            "\x09\0\0\0\0\0\0\0\x40"s  // field 1, 64 bits: 2.0
            "\x10\xAC\x02"s            // field 2, varint: 300 = 0b10'0101100
            "\x2A\x0A"s                // field 5, 10 bytes: the summary
            "\x0A\x08"s                // field 1, 8 bytes: its value
            "\x0A\x01"
            "a"s                   // field 1, 1 byte: the tag
            "\x15\0\0\x80\x3F"s);  // field 2, 32 bits: 1.0
}

TEST(EventFile, SaysThatATrainingGoesOnFromAnEarlierStep) {
  const TemporaryFolder folder;
  EventFile file{folder.path(), 1.0};
  file.restart(60, 2.0);
  const auto event = fields_of(records_of(text_of(file.path())).at(1));
  EXPECT_EQ(number_at<std::int64_t>(event.at(2), 0), 60);
  EXPECT_EQ(number_at<std::int64_t>(fields_of(event.at(7)).at(1), 0), 1);  // SessionLog.START
}

TEST(EventFile, LeavesAFileOfTheSameSecondAlone) {
  const TemporaryFolder folder;
  EventFile{folder.path(), 1.0}.scalar("a", 1, 1.0, 1.1);
  EventFile{folder.path(), 1.5}.scalar("a", 2, 1.0, 1.6);
  for (const char* name : {"events.out.tfevents.0000000001.modsearch", "events.out.tfevents.0000000001.modsearch.1"}) {
    EXPECT_EQ(records_of(text_of(folder.path() / name)).size(), 2U) << name;
  }
}

TEST(EventFile, SaysWhereItCannotBeWritten) {
  const TemporaryFolder folder;
  const auto file = folder.write("taken", "");
  try {
    const EventFile events{file, 1.0};
    FAIL() << "opened in a file";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string() + ": cannot be made: "));
  }
}

TEST(EventFile, IsReadByTensorBoard) {
  if (std::system("python3 -c 'import tensorboard' 2> /dev/null") != 0) {
    GTEST_SKIP() << "python3 has no package tensorboard";
  }
  const TemporaryFolder folder;
  {
    EventFile first{folder.path(), 100.0};
    for (std::int64_t step = 0; step < 5; ++step) {
      first.scalar("evaluation/return", step, 0.5 * static_cast<double>(step), 100.0 + static_cast<double>(step));
    }
    EventFile second{folder.path(), 200.0};
    second.restart(3, 200.0);
    second.scalar("evaluation/return", 3, -1.0, 201.0);
  }
  const auto script = folder.write("read.py", R"(import sys
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
events = EventAccumulator(sys.argv[1]).Reload()
assert events.Tags()["scalars"] == ["evaluation/return"], events.Tags()
print([(e.step, e.value, e.wall_time) for e in events.Scalars("evaluation/return")])
)");
  const auto output = folder.path() / "output";
  const std::string command = "python3 '" + script.string() + "' '" + folder.path().string() + "' > '" +
                              output.string() + "' 2> '" + output.string() + ".errors'";
  ASSERT_EQ(std::system(command.c_str()), 0) << text_of(output.string() + ".errors");
  EXPECT_EQ(text_of(output), "[(0, 0.0, 100.0), (1, 0.5, 101.0), (2, 1.0, 102.0), (3, -1.0, 201.0)]\n");
}

}  // namespace
}  // namespace modsearch
