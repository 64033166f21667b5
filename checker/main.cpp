#include <checker/certificate.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

namespace {

constexpr const char* kHelp =
    R"(modsearch-check: checks a certificate of optimality, without any code of the search that wrote it

usage: modsearch-check [--json] CERTIFICATE

  --json   the result for machines
  --help   this text

Reads the problem that the certificate names, derives all sequences of module types and their arms, and checks with
rounded-outward arithmetic that no achieved design scores above the claimed bound.

exit status: 0 accepted, 1 rejected (with the reason), 2 the input cannot be read

Example: modsearch-check out/certificate.json
)";

using modsearch_check::Json;

int report(const std::string& verdict, const std::string& reason, bool as_json, int status) {
  if (as_json) {
    std::cout << Json{{"verdict", verdict}, {"reason", reason}}.dump(2, ' ', true, Json::error_handler_t::replace)
              << '\n';
  } else {
    (status == 1 ? std::cout : std::cerr) << verdict << ": " << modsearch_check::printable(reason) << '\n';
  }
  return status;
}

Json as_json(const modsearch_check::Proof& proof) {
  Json json{{"verdict", "accepted"},
            {"problem", proof.problem},
            {"collision", proof.level},
            {"maxModules", proof.max_modules},
            {"sequences", proof.count.sequences},
            {"excludedByReach", proof.count.excluded},
            {"leaves", proof.count.leaves},
            {"statement", modsearch_check::in_words(proof)}};
  if (proof.unreachable) {
    json["unreachable"] = true;
  } else {
    json["upper"] = proof.upper;
  }
  if (proof.lower) json["lower"] = *proof.lower;
  if (proof.gap) json["gap"] = *proof.gap;
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  std::string file;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--help" || argument == "-h") {
      std::cout << kHelp;
      return 0;
    }
    if (argument == "--json") {
      json = true;
    } else if (!file.empty() || argument.starts_with("--")) {
      return report("bad usage", argument + " is one argument too many (see --help)", json, 2);
    } else {
      file = argument;
    }
  }
  if (file.empty()) return report("bad usage", "the certificate to check is missing (see --help)", json, 2);
  try {
    const modsearch_check::Proof proof = modsearch_check::check_certificate(file);
    std::cout << (json ? as_json(proof).dump(2) + "\n" : modsearch_check::in_words(proof)) << std::flush;
    if (!std::cout) return report("failed", "the answer cannot be written", json, 2);
    return 0;
  } catch (const modsearch_check::Rejected& reason) {
    return report("rejected", reason.what(), json, 1);
  } catch (const modsearch_check::Malformed& reason) {
    return report("cannot be read", reason.what(), json, 2);
  } catch (const std::exception& error) {
    return report("failed", error.what(), json, 3);
  }
}
