#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <checker/certificate.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

namespace {

constexpr const char* kHelp =
    R"(modsearch-check: checks a certificate of optimality, without any code of the search that wrote it

usage: modsearch-check [--json] CERTIFICATE

  --json   the result for machines
  --help   this text

Reads the problem that the certificate names, derives all sequences of module types and their arms, and checks with
rounded-outward arithmetic that no achieved design scores above the claimed bound.

exit status: 0 accepted, 1 rejected (with the reason), 2 the input cannot be read or the answer not be written,
3 the check failed

Example: modsearch-check out/certificate.json
)";

using modsearch_check::Json;

// A descriptor that the caller closed must not become that of a file; writing to stdout then still fails. A reader that
// has gone away is an error of the write and no signal.
void secure_standard_streams() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) != -1 || errno != EBADF) continue;
    if (::open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY) != descriptor) ::_exit(3);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool write(std::FILE* stream, std::string_view text) {
  return std::fwrite(text.data(), 1, text.size(), stream) == text.size() && std::fflush(stream) == 0;
}

// `status`, if the answer can be written: an answer that is lost is none.
int answer(std::string_view text, int status) {
  if (write(stdout, text)) return status;
  write(stderr, "failed: the answer cannot be written to the standard output\n");
  return 2;
}

int report(const std::string& verdict, const std::string& reason, bool as_json, int status) {
  if (as_json) {
    const Json json{{"verdict", verdict}, {"reason", reason}};
    return answer(json.dump(2, ' ', true, Json::error_handler_t::replace) + '\n', status);
  }
  const std::string text = verdict + ": " + modsearch_check::printable(reason) + '\n';
  if (status == 1) return answer(text, status);
  write(stderr, text);
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
  secure_standard_streams();
  std::string file;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--help" || argument == "-h") {
      return answer(kHelp, 0);
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
    return answer(json ? as_json(proof).dump(2) + '\n' : modsearch_check::in_words(proof), 0);
  } catch (const modsearch_check::Rejected& reason) {
    return report("rejected", reason.what(), json, 1);
  } catch (const modsearch_check::Malformed& reason) {
    return report("cannot be read", reason.what(), json, 2);
  } catch (const std::exception& error) {
    return report("failed", error.what(), json, 3);
  }
}
