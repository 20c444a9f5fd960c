#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs all tests.
#   cmake/test.sh [CTEST_ARGUMENT ...]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

build_project release
say "checking the format of the sources"
(cd "$source_dir" && git ls-files '*.h' '*.cc' |
  xargs clang-format-14 --dry-run --Werror)
say "running the tests (about 10 minutes on two cores)"
ctest --test-dir "$build_dir" --output-on-failure "$@"
