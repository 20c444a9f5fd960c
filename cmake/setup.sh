# shellcheck shell=bash
# Sourced by the other scripts: installs what is missing, gets COLMAP, and
# configures and builds the project into $build_dir with the given preset.

# Else a command that fails inside $(...) would be passed over.
shopt -s inherit_errexit

source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
readonly source_dir

say() { echo "[structnerf] $*" >&2; }
die() { say "error: $*"; exit 1; }

# Ends if two folders have the same name, under which results are kept.
require_different_names() {
  local same
  same=$(basename -a "$@" | sort | uniq -d | head -n 1)
  [ -z "$same" ] ||
    die "two scenes are called $same, so their results could not be told apart; rename a folder"
}

install_packages() {
  if ! grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release; then
    say "not on Debian 12, so what cmake/packages.txt lists is taken to be there"
    return
  fi
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
  # Another apt-get, say of automatic upgrades, is waited for.
  local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq
             -o DPkg::Lock::Timeout=600)
  if ! "${apt[@]}" update ||
      ! "${apt[@]}" install -y --no-install-recommends "${missing[@]}" > /dev/null; then
    die "apt-get could not install ${missing[*]}"
  fi
}

# Prints the folder of COLMAP's CMake package to build against: the user's own if
# CMake finds one of a version that will do, else ours from the cache.
find_colmap() {
  local probe found prefix
  probe=$(mktemp -d)
  cat > "$probe/CMakeLists.txt" <<'PROBE'
cmake_minimum_required(VERSION 3.25)
project(probe LANGUAGES C CXX)
find_package(COLMAP QUIET)
if(COLMAP_FOUND AND COLMAP_VERSION VERSION_GREATER_EQUAL 3.10
    AND COLMAP_VERSION VERSION_LESS 4.2)
  file(WRITE "${CMAKE_BINARY_DIR}/found" "${COLMAP_DIR}")
endif()
PROBE
  cmake -S "$probe" -B "$probe/build" > /dev/null 2>&1 || true
  found=$(cat "$probe/build/found" 2> /dev/null || true)
  rm -rf "$probe"
  if [ -n "$found" ]; then
    say "using the COLMAP in $found"
    echo "$found"
  else
    prefix=$("$source_dir/cmake/build_colmap.sh")
    echo "$prefix/share/colmap"
  fi
}

# build_project PRESET [TARGET ...]
build_project() {
  local preset="$1" colmap_dir
  shift
  install_packages
  colmap_dir=$(find_colmap)
  build_dir="$source_dir/build/$preset"
  say "building into $build_dir (about 10 minutes the first time, on two cores)"
  (cd "$source_dir" &&
    cmake --preset "$preset" -DCOLMAP_DIR="$colmap_dir" > /dev/null &&
    cmake --build "build/$preset" ${1:+--target "$@"})
}
