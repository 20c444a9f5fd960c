#!/usr/bin/env bash
# Measures how time and memory grow with views, pixels and threads, on photographs of
# the generated room, and prints one table.
#   cmake/growth.sh OUTPUT_FOLDER [OPTION ...]
# OPTION: of structnerf_dense, for all runs, for instance --StructNeRF.quality low.
# Runs whose result is in OUTPUT_FOLDER already are not repeated.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 1; }
# shellcheck source=cmake/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

output=$1
shift
build_project release colmap-structnerf structnerf_make_room >&2
mkdir -p "$output"

# One row: what report.txt says about a run.
print_row() { # report, views, size, threads
  awk -v views="$2" -v size="$3" -v threads="$4" '
    # Seconds of a stage in the line of times.
    function seconds(stage) {
      return match($0, stage " [0-9.]+ s") \
        ? substr($0, RSTART + length(stage), RLENGTH - length(stage) - 2) + 0 : 0
    }
    /^Time / {
      wall = $2
      training = seconds("Training")
      maps = seconds("Rendering depth maps")
      rest = wall - training - maps
    }
    /^CPU time/ { cpu = $3 }
    /^Peak memory/ { peak = $3; expected = $6 }
    END {
      printf "| %d | %s | %d | %.0f | %.0f | %.0f | %.0f | %.0f | %.2f | %.2f |\n",
        views, size, threads, wall, training, maps, rest, cpu, peak, expected
    }' "$1"
}

measure() { # views, width, height, threads, options
  local views=$1 width=$2 height=$3 threads=$4 name room
  shift 4
  name=${views}_${width}x${height}_$threads
  if [ ! -e "$output/$name.txt" ]; then
    say "$views views of ${width}x$height, $threads threads"
    room=$(mktemp -d "$output/room.XXXXXX")
    "$build_dir/tests/tools/structnerf_make_room" "$room/scene" \
      --views "$views" --width "$width" --height "$height" > /dev/null
    # All of COLMAP's threads, too.
    taskset -c "0-$((threads - 1))" "$build_dir/colmap_plugin/colmap-structnerf" \
      structnerf_dense --image_path "$room/scene/images" \
      --input_path "$room/scene/sparse/0" --output_path "$room/dense" \
      --StructNeRF.num_threads "$threads" "$@" > "$room/log" 2>&1 ||
      die "the run failed: $(tail -n1 "$room/log")"
    mv "$room/dense/structnerf/report.txt" "$output/$name.txt"
    rm -r "$room"
  fi
  print_row "$output/$name.txt" "$views" "${width}x$height" "$threads"
}

cores=$(nproc)
echo "| views | size | threads | all s | training s | maps s | rest s | CPU s | peak GB | expected GB |"
echo "|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|"
for views in 5 10 20 50 100; do
  measure "$views" 640 480 "$cores" "$@"
done
measure 500 320 240 "$cores" "$@"
for size in "368 276" "1152 864" "1632 1224"; do
  # shellcheck disable=SC2086 # two words
  measure 20 $size "$cores" "$@"
done
for ((threads = 1; threads < cores; threads *= 2)); do
  measure 20 640 480 "$threads" "$@"
done
