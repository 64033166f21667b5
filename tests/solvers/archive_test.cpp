#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <modsearch/problem/files.hpp>
#include <modsearch/solvers/archive.hpp>
#include <modsearch/solvers/crc32c.hpp>
#include <stdexcept>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using test::text_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename Use>
std::string refusal(Use&& use) {
  try {
    use();
  } catch (const FileError& error) {
    return error.what();
  }
  return "no refusal";
}

std::string load_refusal(const std::filesystem::path& file) {
  return refusal([&] { static_cast<void>(Archive::load(file)); });
}

Archive sample() {
  Archive archive;
  archive.put("floats", std::vector<float>{1.5F, -0.0F, std::numeric_limits<float>::denorm_min()});
  archive.put("numbers", std::vector<double>{0.1, std::numeric_limits<double>::infinity()});
  archive.put("integers", std::vector<std::int64_t>{std::numeric_limits<std::int64_t>::min(), -1, 7});
  archive.put("unsigned", std::vector<std::uint64_t>{std::numeric_limits<std::uint64_t>::max()});
  archive.put("texts", std::vector<std::string>{"", "two\nlines", std::string(3, '\0')});
  archive.put("nothing", std::vector<float>{});
  archive.put_integer("episode", 47'000);
  archive.put_number("epsilon", 0.01);
  archive.put_text("agent", "mpdqn");
  return archive;
}

TEST(Archive, GivesBackBitByBitWhatWasPut) {
  const TemporaryFolder folder;
  sample().save(folder.path() / "a");
  const Archive archive = Archive::load(folder.path() / "a");
  const std::vector<float> floats = archive.floats("floats");
  ASSERT_EQ(floats.size(), 3U);
  EXPECT_EQ(floats[0], 1.5F);
  EXPECT_TRUE(floats[1] == 0.0F && std::signbit(floats[1]));
  EXPECT_EQ(floats[2], std::numeric_limits<float>::denorm_min());
  EXPECT_THAT(archive.numbers("numbers"), ElementsAre(0.1, std::numeric_limits<double>::infinity()));
  EXPECT_THAT(archive.integers("integers"), ElementsAre(std::numeric_limits<std::int64_t>::min(), -1, 7));
  EXPECT_THAT(archive.unsigned_integers("unsigned"), ElementsAre(std::numeric_limits<std::uint64_t>::max()));
  EXPECT_THAT(archive.texts("texts"), ElementsAre("", "two\nlines", std::string(3, '\0')));
  EXPECT_TRUE(archive.floats("nothing").empty());
  EXPECT_EQ(archive.integer("episode"), 47'000);
  EXPECT_EQ(archive.number("epsilon"), 0.01);
  EXPECT_EQ(archive.text("agent"), "mpdqn");
  EXPECT_TRUE(archive.has("agent"));
  EXPECT_FALSE(archive.has("Agent"));
  EXPECT_THAT(archive.names(), ElementsAre("agent", "episode", "epsilon", "floats", "integers", "nothing", "numbers",
                                           "texts", "unsigned"));
}

TEST(Archive, CanBeReadBeforeItIsSavedAndPutIntoAfterItWasLoaded) {
  EXPECT_EQ(sample().integer("episode"), 47'000);
  const TemporaryFolder folder;
  sample().save(folder.path() / "a");
  Archive archive = Archive::load(folder.path() / "a");
  archive.put_integer("steps", 3);
  archive.save(folder.path() / "b");
  EXPECT_EQ(Archive::load(folder.path() / "b").integer("steps"), 3);
}

TEST(Archive, IsTheFileThatItsHeaderDescribes) {
  const TemporaryFolder folder;
  Archive archive;
  archive.put("x", std::vector<float>{1.0F});
  archive.save(folder.path() / "a");
  using namespace std::string_literals;
  const std::string expected = "MSARCHIV"s + "\x01\0\0\0"s +                   // version 1
                               "\x01\0\0\0"s + "\x04\0\0\0"s +                 // one character, floats
                               "\x04\0\0\0\0\0\0\0"s + "x" + "\0\0\x80\x3f"s;  // four bytes: 1.0F
  const std::string text = text_of(folder.path() / "a");
  ASSERT_EQ(text.size(), expected.size() + 4);
  EXPECT_EQ(text.substr(0, expected.size()), expected);
  std::uint32_t checksum = 0;
  std::memcpy(&checksum, text.data() + expected.size(), 4);
  EXPECT_EQ(checksum, crc32c(std::as_bytes(std::span{expected})));
}

TEST(Archive, RefusesAFileCutOffAnywhere) {
  const TemporaryFolder folder;
  sample().save(folder.path() / "a");
  const std::string whole = text_of(folder.path() / "a");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto file = folder.write("cut", whole.substr(0, size));
    EXPECT_THAT(load_refusal(file), HasSubstr(file.string() + ": ")) << size;
  }
  EXPECT_THAT(load_refusal(folder.write("cut", whole.substr(0, 10))), HasSubstr("cut off after 10 bytes"));
  EXPECT_THAT(load_refusal(folder.write("cut", whole.substr(0, 100))), HasSubstr("was truncated or altered"));
}

TEST(Archive, RefusesAFileWithAnyByteAltered) {
  const TemporaryFolder folder;
  sample().save(folder.path() / "a");
  const std::string whole = text_of(folder.path() / "a");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string altered = whole;
    altered[i] = static_cast<char>(altered[i] ^ 0x10);
    EXPECT_NE(load_refusal(folder.write("altered", altered)), "no refusal") << i;
  }
  EXPECT_THAT(load_refusal(folder.write("longer", whole + "x")), HasSubstr("was truncated or altered"));
}

TEST(Archive, RefusesAForeignFileALaterVersionAndNoFile) {
  const TemporaryFolder folder;
  EXPECT_THAT(load_refusal(folder.write("png", "\x89PNG and so on, for more than twenty bytes")),
              HasSubstr("is not an archive of modsearch"));
  EXPECT_THAT(load_refusal(folder.write("empty", "")), HasSubstr("is not an archive of modsearch"));
  sample().save(folder.path() / "a");
  std::string later = text_of(folder.path() / "a");
  later[8] = 2;
  EXPECT_THAT(load_refusal(folder.write("later", later)), HasSubstr("has version 2 of the format (limit 1)"));
  EXPECT_THAT(load_refusal(folder.path() / "none"), HasSubstr("there is no such file"));
  EXPECT_THAT(load_refusal(folder.path()), HasSubstr("is a directory"));
}

/// A file of one entry with these header numbers and a right checksum.
std::string forged(std::uint32_t name_size, std::uint32_t kind, std::uint64_t size, const std::string& rest) {
  std::string image = "MSARCHIV";
  const auto add = [&](auto number) { image.append(reinterpret_cast<const char*>(&number), sizeof number); };
  add(std::uint32_t{1});
  add(name_size);
  add(kind);
  add(size);
  image += rest;
  add(crc32c(std::as_bytes(std::span{image})));
  return image;
}

TEST(Archive, RefusesForgedEntriesWithoutReadingBeyondTheFile) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& image) { return load_refusal(folder.write("forged", image)); };
  EXPECT_EQ(refuse(forged(1, 0, 2, "xab")), "no refusal");
  EXPECT_THAT(refuse(forged(1, 0, 3, "xab")), HasSubstr("has a malformed entry at byte 12"));
  EXPECT_THAT(refuse(forged(1, 0, ~std::uint64_t{0}, "xab")), HasSubstr("has a malformed entry at byte 12"));
  EXPECT_THAT(refuse(forged(~std::uint32_t{0}, 0, 1, "xab")), HasSubstr("has a malformed entry at byte 12"));
  EXPECT_THAT(refuse(forged(0, 0, 3, "xab")), HasSubstr("has a malformed entry at byte 12"));  // no name
  EXPECT_THAT(refuse(forged(1, 6, 2, "xab")), HasSubstr("has a malformed entry at byte 12"));  // no such kind
  EXPECT_THAT(refuse(forged(1, 4, 2, "xab")), HasSubstr("has a malformed entry at byte 12"));  // half a float
  EXPECT_THAT(refuse(forged(1, 0, 1, "xab")), HasSubstr("has a malformed entry at byte 30"));  // a byte is left over
  const Archive texts = Archive::load(folder.write("texts", forged(1, 1, 9, std::string("x\x02\0\0\0\0\0\0\0a", 10))));
  EXPECT_THAT(refusal([&] { static_cast<void>(texts.texts("x")); }), HasSubstr("entry 'x': ends within a text"));
}

TEST(Archive, NamesTheEntryThatIsMissingOrHoldsSomethingElse) {
  const TemporaryFolder folder;
  sample().save(folder.path() / "a");
  const Archive archive = Archive::load(folder.path() / "a");
  const std::string label = (folder.path() / "a").string();
  EXPECT_EQ(refusal([&] { static_cast<void>(archive.floats("weights")); }), label + ": entry 'weights': is missing");
  EXPECT_EQ(refusal([&] { static_cast<void>(archive.numbers("floats")); }),
            label + ": entry 'floats': holds single-precision numbers, not double-precision numbers");
  EXPECT_EQ(refusal([&] { static_cast<void>(archive.integer("integers")); }),
            label + ": entry 'integers': holds 3 values (limit: 1)");
}

TEST(Archive, RefusesANameTwiceAndNoName) {
  Archive archive = sample();
  EXPECT_THROW(archive.put_integer("agent", 1), std::invalid_argument);
  EXPECT_THROW(archive.put_integer("", 1), std::invalid_argument);
}

TEST(Archive, SaysThatItCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal([&] { sample().save(folder.path() / "none" / "a"); }), HasSubstr("cannot be written"));
}

TEST(Archive, KeepsAReplayOfAHundredMegabytes) {
  constexpr std::size_t kParts = 500;
  const std::vector<float> part(50'000, 0.25F);
  const TemporaryFolder folder;
  {
    Archive archive;
    for (std::size_t i = 0; i < kParts; ++i) archive.put("part " + std::to_string(i), part);
    archive.save(folder.path() / "replay");
  }
  EXPECT_EQ(Archive::load(folder.path() / "replay").floats("part 499"), part);
}

}  // namespace
}  // namespace modsearch
