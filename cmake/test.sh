#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs all tests.
#   cmake/test.sh [CTEST_ARGUMENT ...]
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

build_project release
say "checking the format of the sources"
(cd "$source_dir" && find nerf colmap_plugin ui tests '(' -name '*.h' -o -name '*.cc' ')' \
  -exec clang-format-14 --dry-run --Werror '{}' +)
say "running the tests (about 10 minutes on two cores)"
ctest --test-dir "$build_dir" --output-on-failure "$@"
