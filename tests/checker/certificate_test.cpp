#include <gmock/gmock.h>

#include <cfenv>
#include <fstream>

#include "naive_certificate.hpp"

namespace modsearch_check {
namespace {

/// What the checker says of a certificate: "accepted", or the reason of its refusal.
std::string verdict(const Json& certificate) {
  const TemporaryFile file{"certificate.json"};
  file.write(certificate.dump());
  try {
    static_cast<void>(check_certificate(file.path()));
    return "accepted";
  } catch (const Rejected& reason) {
    return std::string{"rejected: "} + reason.what();
  } catch (const Malformed& reason) {
    return std::string{"malformed: "} + reason.what();
  }
}

/// seed/fixed to 0.1 % of the mass.
const Json& certificate_of_seed_fixed() {
  static const Json certificate = [] {
    const Rounding up{FE_UPWARD};
    Json made = naive_certificate("seed/fixed", read_problem("seed/fixed", "", 0, 0), 341.923, 1);
    add_incumbent_of_seed_fixed(made);
    return made;
  }();
  return certificate;
}

TEST(Certificate, OfTheFixedTargetIsAccepted) { EXPECT_EQ(verdict(certificate_of_seed_fixed()), "accepted"); }

}  // namespace
}  // namespace modsearch_check
