#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <modsearch/problem/files.hpp>
#include <modsearch/rl/training_csv.hpp>

#include "problem/temporary_folder.hpp"

namespace modsearch {
namespace {

using test::TemporaryFolder;
using test::text_of;
using ::testing::HasSubstr;

const std::string kHeader =
    "episode,steps,updates,epsilon,training_return,evaluation_return,evaluation_deviation,success_share,one_step_share,"
    "evaluation_steps,value_loss,training_s\n";

EvaluationPoint point(std::int64_t episode) {
  EvaluationPoint result;
  result.episode = episode;
  result.steps = 45;
  result.updates = 17;
  result.epsilon = 0.1;
  result.training_return = -12.5;
  result.value_loss = 1e-9;
  result.seconds = 1.0 / 3.0;
  result.evaluation = {
      .mean_return = 341.74, .deviation = 0.0, .success_share = 1.0, .one_step_share = 0.9, .mean_steps = 1.1};
  return result;
}

std::string row(std::int64_t episode) {
  return std::to_string(episode) + ",45,17,0.1,-12.5,341.74,0,1,0.9,1.1,1e-09,0.3333333333333333\n";
}

std::string refusal(const std::filesystem::path& file) {
  try {
    static_cast<void>(load_training_csv(file));
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string() + ": "));
    return error.what();
  }
  return "no refusal";
}

TEST(TrainingCsv, HasARowPerEvaluationAsSoonAsItIsAppended) {
  const TemporaryFolder folder;
  const auto file = folder.write("training.csv", "of an earlier training");
  TrainingCsv log{file};
  EXPECT_EQ(text_of(file), kHeader);
  log.append(point(30));
  EXPECT_EQ(text_of(file), kHeader + row(30));
  log.append(point(60));
  EXPECT_EQ(text_of(file), kHeader + row(30) + row(60));
}

TEST(TrainingCsv, GivesBackTheNumbersBitByBit) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "training.csv";
  TrainingCsv{file}.append(point(30));
  const std::vector<EvaluationPoint> rows = load_training_csv(file);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].episode, 30);
  EXPECT_EQ(rows[0].steps, 45);
  EXPECT_EQ(rows[0].updates, 17);
  EXPECT_EQ(rows[0].epsilon, 0.1);
  EXPECT_EQ(rows[0].training_return, -12.5);
  EXPECT_EQ(rows[0].value_loss, 1e-9);
  EXPECT_EQ(rows[0].seconds, 1.0 / 3.0);
  EXPECT_EQ(rows[0].evaluation.mean_return, 341.74);
  EXPECT_EQ(rows[0].evaluation.deviation, 0.0);
  EXPECT_EQ(rows[0].evaluation.success_share, 1.0);
  EXPECT_EQ(rows[0].evaluation.one_step_share, 0.9);
  EXPECT_EQ(rows[0].evaluation.mean_steps, 1.1);
}

TEST(TrainingCsv, GoesOnWithTheRowsOfTheCheckpointWhateverHasBecomeOfTheFile) {
  const TemporaryFolder folder;
  for (const std::string& left :
       {kHeader + row(30) + row(60) + row(90) + "120,45,1", kHeader + "30,4", std::string{}}) {
    const auto file = folder.write("training.csv", left);
    TrainingCsv log{file, {point(30), point(60)}};
    EXPECT_EQ(text_of(file), kHeader + row(30) + row(60));
    log.append(point(90));
    EXPECT_EQ(text_of(file), kHeader + row(30) + row(60) + row(90));
  }
}

TEST(TrainingCsv, NamesLineAndValueOfWhatItCannotRead) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return refusal(folder.write("training.csv", text)); };
  EXPECT_EQ(read(kHeader), "no refusal");
  EXPECT_EQ(read(kHeader + row(30) + "60,45"), "no refusal");  // cut off
  EXPECT_THAT(read(""), HasSubstr("line 1: is not the header of a training's log"));
  EXPECT_THAT(read("episode,steps\n"), HasSubstr("line 1: is not the header of a training's log"));
  EXPECT_THAT(read(kHeader + row(30) + "60,45\n"), HasSubstr("line 3: has 2 fields (limit 12)"));
  EXPECT_THAT(read(kHeader + "many" + row(30)), HasSubstr("line 2: episode is 'many30', not a number"));
  EXPECT_THAT(read(kHeader + "1.5" + row(30)), HasSubstr("line 2: episode is '1.530', not a number"));
}

TEST(TrainingCsv, SaysWhereItCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THROW(TrainingCsv{folder.path() / "none" / "training.csv"}, FileError);
}

}  // namespace
}  // namespace modsearch
