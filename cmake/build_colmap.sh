#!/usr/bin/env bash
# Builds COLMAP 3.10 once into the per-user cache and prints its prefix on stdout.
# A second checkout, and every later call, finds it there at once.
#
#   STRUCTNERF_CACHE        cache folder (default: ~/.cache/colmap-structnerf)
#   COLMAP_SOURCE_ARCHIVE   colmap_3.10.orig.tar.gz, for machines without network
set -euo pipefail

readonly version=3.10
readonly recipe=2  # raise when the way it is built changes
readonly archive_name=colmap_3.10.orig.tar.gz
readonly archive_sha256=61850f323e201ab6a1abbfb0e4a8b3ba1c4cedbf55e0a5716bdea1df8ae1813a
readonly cache="${STRUCTNERF_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/colmap-structnerf}"
readonly prefix="$cache/colmap-$version-$recipe"

say() { echo "[structnerf] $*" >&2; }
die() { say "error: $*"; exit 1; }

has_checksum() { echo "$archive_sha256  $1" | sha256sum --check --status; }

# Debian's next release carries COLMAP 3.10's upstream archive in its source
# index. A private apt state keeps the system's own package lists untouched.
fetch_archive_with_apt() {
  local work="$1" mirror
  # shellcheck disable=SC2016  # apt's own placeholder
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' \
             'Codename: bookworm' 2>/dev/null | head -n 1)
  [ -n "$mirror" ] || return 1
  mkdir -p "$work/apt/lists/partial"
  local signed=/usr/share/keyrings/debian-archive-keyring.gpg
  echo "deb-src [signed-by=$signed] $mirror trixie main" > "$work/apt/sources.list"
  local apt=(apt-get -qq -o "Dir::Etc::SourceList=$work/apt/sources.list"
             -o Dir::Etc::SourceParts=- -o "Dir::State::Lists=$work/apt/lists"
             -o "Dir::Cache=$work/apt" -o APT::Sandbox::User=)
  "${apt[@]}" update >&2 || return 1
  (cd "$work" && "${apt[@]}" source --tar-only "colmap=$version-2" >&2) || return 1
}

find_archive() {
  local work="$1"
  if [ -n "${COLMAP_SOURCE_ARCHIVE:-}" ]; then
    [ -r "$COLMAP_SOURCE_ARCHIVE" ] ||
      die "COLMAP_SOURCE_ARCHIVE=$COLMAP_SOURCE_ARCHIVE cannot be read"
    cp "$COLMAP_SOURCE_ARCHIVE" "$work/$archive_name"
  else
    fetch_archive_with_apt "$work" ||
      die "could not fetch $archive_name with apt; download it elsewhere and set COLMAP_SOURCE_ARCHIVE to its path"
  fi
  has_checksum "$work/$archive_name" ||
    die "$archive_name does not have the expected SHA-256 $archive_sha256"
}

if [ -x "$prefix/bin/colmap" ]; then
  echo "$prefix"
  exit 0
fi

mkdir -p "$cache"
exec 9> "$cache/colmap.lock"
flock 9  # a second build waits here and then finds the first one's result
if [ ! -x "$prefix/bin/colmap" ]; then
  work=$(mktemp -d "$cache/colmap-build.XXXXXX")
  trap 'rm -rf "$work"' EXIT
  say "building COLMAP $version into $prefix (once per user; about 20 minutes on two cores)"
  find_archive "$work"
  mkdir "$work/source"
  tar -xzf "$work/$archive_name" -C "$work/source" --strip-components=1
  # 3.10 fixes C++14, under which Eigen's vectors have another definition than
  # in our C++17 sources (colmap/util/eigen_alignment.h).
  sed -i 's/set(CMAKE_CXX_STANDARD 14)/set(CMAKE_CXX_STANDARD 17)/' "$work/source/CMakeLists.txt"
  grep -q 'set(CMAKE_CXX_STANDARD 17)' "$work/source/CMakeLists.txt" ||
    die "COLMAP's CMakeLists.txt is not the one this script knows"
  log="$cache/colmap-build.log"
  cmake -S "$work/source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_INSTALL_PREFIX="$prefix" -DCUDA_ENABLED=OFF -DIPO_ENABLED=OFF \
    -DTESTS_ENABLED=OFF > "$log" 2>&1 || die "configuring COLMAP failed, see $log"
  cmake --build "$work/build" >> "$log" 2>&1 || die "compiling COLMAP failed, see $log"
  DESTDIR="$work/install" cmake --install "$work/build" --strip >> "$log" 2>&1 ||
    die "installing COLMAP failed, see $log"
  rm -rf "$prefix"
  mv "$work/install$prefix" "$prefix"
fi
echo "$prefix"
