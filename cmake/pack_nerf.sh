#!/usr/bin/env bash
# Packs nerf/ with its tests, structnerf_train, the headers and small libraries
# that they need, and scene files into one archive for a machine with only a
# compiler, CMake, ninja and PyTorch. There, one command does the rest:
#
#   cmake/pack_nerf.sh nerf.tar.gz [SCENE_FILE ...]    here
#   tar xzf nerf.tar.gz && structnerf-nerf/run.sh      there
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

readonly max_bytes=$((64 << 20))
readonly packages=(libeigen3-dev libhwy-dev libgtest-dev libgmock-dev
  libbenchmark-dev)

[ $# -ge 1 ] ||
  die "say where to: $0 ARCHIVE.tar.gz [SCENE_FILE ...]"
archive=$(realpath "$1")
shift
install_packages

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root="$work/structnerf-nerf"
mkdir -p "$root/source" "$root/scenes"

# Tracked files as they are in the working tree.
git -C "$source_dir" ls-files -z -- CMakeLists.txt LICENSE cmake nerf tests \
  ':!tests/colmap_plugin' ':!tests/end_to_end' ':!tests/ui' |
  tar -C "$source_dir" --null --files-from=- -cf - |
  tar -C "$root/source" -xf -
cp "$source_dir/cmake/run_packed.sh" "$root/run.sh"

# What the packages hold below /usr, with the files that their links to
# libraries lead to.
mkdir "$root/prefix"
dpkg -L "${packages[@]}" | while read -r path; do
  case "$path" in
    /usr/share/doc/*|/usr/src/*) ;;
    *.so) printf '%s\n' "$path"* ;;
    *) [ ! -f "$path" ] || printf '%s\n' "$path" ;;
  esac
done | sed 's,^/usr/,,' |
  tar -C /usr --files-from=- -cf - | tar -C "$root/prefix" -xf -

for scene in "$@"; do
  [ "$(head -c 7 "$scene")" = SNSCENE ] ||
    die "$scene is not a scene; write one with --StructNeRF.export_path"
  cp "$scene" "$root/scenes/"
done

tar -C "$work" -czf "$archive.partial" structnerf-nerf
bytes=$(stat -c %s "$archive.partial")
if [ "$bytes" -gt "$max_bytes" ]; then
  rm "$archive.partial"
  die "the archive would have $((bytes >> 20)) MiB, more than $((max_bytes >> 20)); give fewer scenes"
fi
mv "$archive.partial" "$archive"
say "$archive has $((bytes >> 10)) KiB"
