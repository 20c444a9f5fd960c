#!/usr/bin/env bash
# Installs what is missing, builds, and runs the dense stage on a generated room.
#   cmake/demo.sh [OUTPUT_FOLDER]     (default: structnerf_demo)
set -euo pipefail
# shellcheck source=cmake/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

output=${1:-structnerf_demo}
[ ! -e "$output" ] || die "$output exists already; give another folder"
# All that is installed, and the room.
build_project release colmap-structnerf structnerf_train structnerf_make_room
mkdir -p "$output"
say "generating a room with known depth in $output/room"
"$build_dir/tests/tools/structnerf_make_room" "$output/room"
say "reconstructing it (about 2 minutes on two cores)"
"$build_dir/colmap_plugin/colmap-structnerf" structnerf_dense \
  --image_path "$output/room/images" --input_path "$output/room/sparse/0" \
  --output_path "$output/dense"
say "done: depth maps in $output/dense/stereo, cloud in $output/dense/fused.ply"
