# Sourced by demo.sh and test.sh: installs what is missing, gets COLMAP, and
# configures and builds the project into $build_dir with the given preset.

readonly source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { echo "[structnerf] $*" >&2; }
die() { say "error: $*"; exit 1; }

install_packages() {
  command -v dpkg-query > /dev/null ||
    die "this script installs packages on Debian 12; elsewhere install what cmake/packages.txt lists and use the CMake presets"
  local missing=() package
  while read -r package; do
    case "$package" in ''|'#'*) continue ;; esac
    dpkg-query -W -f '${Status}' "$package" 2> /dev/null |
      grep -q 'ok installed' || missing+=("$package")
  done < "$source_dir/cmake/packages.txt"
  [ ${#missing[@]} -gt 0 ] || return 0
  local sudo=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo > /dev/null ||
      die "packages are missing and sudo is not there to install them: ${missing[*]}"
    sudo=(sudo)
  fi
  say "installing ${#missing[@]} packages (about 2 minutes)"
  "${sudo[@]}" apt-get -qq update
  DEBIAN_FRONTEND=noninteractive "${sudo[@]}" apt-get -qq install -y \
    --no-install-recommends "${missing[@]}" > /dev/null
}

# Prints the prefix of the COLMAP to build against: the user's own if CMake finds
# one with development files, else ours from the cache.
find_colmap() {
  local probe found
  probe=$(mktemp -d)
  cat > "$probe/CMakeLists.txt" <<'PROBE'
cmake_minimum_required(VERSION 3.25)
project(probe LANGUAGES C CXX)
find_package(COLMAP QUIET)
if(COLMAP_FOUND)
  file(WRITE ${CMAKE_BINARY_DIR}/found "${COLMAP_DIR}")
endif()
PROBE
  cmake -S "$probe" -B "$probe/build" > /dev/null 2>&1 || true
  found=$(cat "$probe/build/found" 2> /dev/null || true)
  rm -rf "$probe"
  if [ -n "$found" ]; then
    say "using the COLMAP in $found"
    (cd "$found/../.." && pwd)
  else
    "$source_dir/cmake/build_colmap.sh"
  fi
}

# build_project PRESET [TARGET ...]
build_project() {
  local preset="$1" colmap_prefix
  shift
  install_packages
  colmap_prefix=$(find_colmap)
  build_dir="$source_dir/build/$preset"
  say "building into $build_dir (about 10 minutes the first time, on two cores)"
  (cd "$source_dir" &&
    cmake --preset "$preset" -DCMAKE_PREFIX_PATH="$colmap_prefix" > /dev/null &&
    cmake --build "build/$preset" ${1:+--target "$@"})
}
