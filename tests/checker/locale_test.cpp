#include <gmock/gmock.h>

#include <checker/certificate.hpp>
#include <modsearch/baselines/certificate.hpp>
#include <modsearch/problem/files.hpp>

#include "german_locale.hpp"
#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

std::string certificate_of(const std::string& id) {
  modsearch::Meter meter{{.evaluations = 1'000'000'000, .seconds = 60.0}};
  return modsearch::make_certificate(*modsearch::load_problem(id), {.gap = 1e-2},
                                     {id, std::nullopt, R"({"type":"algorithm1"})"}, meter)
      .json;
}

TEST(Locale, ChangesNeitherACertificateNorWhatIsSaidOfIt) {
  const std::string plain = certificate_of("seed/fixed");
  const TemporaryFile file{"locale.json"};
  file.write(plain);
  const std::string words = in_words(check_certificate(file.path()));

  const modsearch::test::GermanLocale german;
  if (!modsearch::test::GermanLocale::is_set()) GTEST_SKIP() << "no locale with a decimal comma, and none can be made";
  EXPECT_EQ(certificate_of("seed/fixed"), plain);
  EXPECT_EQ(in_words(check_certificate(file.path())), words);
  EXPECT_THAT(words, testing::HasSubstr("scores above 34"));
}

}  // namespace
}  // namespace modsearch_check
