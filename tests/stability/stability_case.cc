#include "tests/stability/stability_case.h"

#include <cstdio>
#include <exception>

namespace structnerf {
namespace {

struct CaseOutcome {
  bool is_ok = false;
  const char* state = "";
  std::string text;
};

CaseOutcome RunCase(const StabilityCase& stability_case) {
  const std::string& refusal = stability_case.refusal;
  try {
    const std::string measured = stability_case.run();
    return {refusal.empty() || stability_case.is_refusal_optional,
            "finite",
            measured};
  } catch (const UnstableError& error) {
    return {false, "UNSTABLE", error.text};
  } catch (const std::exception& error) {
    const std::string text = error.what();
    const bool is_one_line =
        !text.empty() && text.find('\n') == std::string::npos;
    return {!refusal.empty() && is_one_line &&
                text.find(refusal) != std::string::npos,
            "refused",
            text};
  }
}

}  // namespace

void RequireStable(const bool condition, const std::string& text) {
  if (!condition) {
    throw UnstableError{text};
  }
}

std::string ShortNumber(const double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2g", value);
  return text;
}

int RunStabilityCases(const std::vector<StabilityCase>& cases) {
  int num_failed = 0;
  for (const StabilityCase& stability_case : cases) {
    const CaseOutcome outcome = RunCase(stability_case);
    num_failed += !outcome.is_ok;
    std::printf("%-4s  %-44s  %-8s  %s\n",
                outcome.is_ok ? "ok" : "FAIL",
                stability_case.name.c_str(),
                outcome.state,
                outcome.text.c_str());
    std::fflush(stdout);
  }
  return num_failed;
}

}  // namespace structnerf
