#!/usr/bin/env bash
# Compares runs that are given some time with runs whose schedule is four times as long
# and which are ended, as by Ctrl-C, after as many seconds of training, and prints one
# table. Both have the quality and the sweeps of matching that were chosen for the time.
#   cmake/cut_off.sh OUTPUT_FOLDER SECONDS SCENE_FOLDER...
# SCENE_FOLDER holds images, sparse/0 and depth (16-bit PNGs in millimetres). SEEDS=3 is
# the number of runs of each, OPTIONS are more options for all of them. Runs whose result
# is in OUTPUT_FOLDER already are not repeated. Nothing else should run meanwhile.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 1; }
# shellcheck source=cmake/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

output=$1 seconds=$2
shift 2
require_different_names "$@"
build_project release colmap-structnerf structnerf_results_table >&2
program=$build_dir/colmap_plugin/colmap-structnerf
mkdir -p "$output/runs"

# A value of a report.json, the first of that name after a line with another name.
report_value() { # report, name before, name
  awk -v before="\"$2\":" -v name="\"$3\":" '
    index($0, before) { is_near = 1 }
    is_near && index($0, name) { gsub(/[",]/, "", $2); print $2; exit }' "$1"
}

# One run in a folder that goes away; its report and its measurements stay.
run_once() { # scene folder, folder of the result, seconds to end it after or 0, options
  local scene=$1 result=$2 end_after=$3 work pid
  shift 3
  work=$(mktemp -d "$output/run.XXXXXX")
  # shellcheck disable=SC2086 # options are words
  "$program" structnerf_dense --image_path "$scene/images" \
    --input_path "$scene/sparse/0" --output_path "$work/dense" "$@" ${OPTIONS:-} \
    > "$work/log" 2>&1 &
  pid=$!
  if [ "$end_after" != 0 ]; then
    while kill -0 $pid 2> /dev/null && ! grep -q '^Training' "$work/log"; do
      sleep 0.1
    done
    sleep "$end_after"
    kill -INT $pid || true
  fi
  wait $pid || die "the run failed: $(tail -n1 "$work/log")"
  mkdir "$work/result"
  "$program" structnerf_eval --workspace_path "$work/dense" \
    --image_path "$scene/images" --input_path "$scene/sparse/0" \
    --ground_truth_path "$scene/depth" --output_path "$work/result/eval.json" \
    >> "$work/log" 2>&1 || die "the evaluation failed: $(tail -n1 "$work/log")"
  cp "$work/dense/structnerf/report.json" "$work/result/"
  mkdir -p "$(dirname "$result")"
  mv "$work/result" "$result"
  rm -r "$work"
}

for scene in "$@"; do
  runs=$output/runs/$(basename "$scene")
  for ((seed = 0; seed < ${SEEDS:-3}; ++seed)); do
    planned=$runs/planned_$seconds/$seed
    cut_off=$runs/cut_off_$seconds/$seed
    report=$planned/report.json
    if [ ! -e "$planned" ]; then
      say "$scene, planned for $seconds s, seed $seed"
      run_once "$scene" "$planned" 0 --StructNeRF.seed "$seed" \
        --StructNeRF.max_minutes "$(awk -v s="$seconds" 'BEGIN { print s / 60 }')"
    fi
    if [ ! -e "$cut_off" ]; then
      say "$scene, cut off, seed $seed"
      run_once "$scene" "$cut_off" "$(report_value "$report" training seconds)" \
        --StructNeRF.seed "$seed" \
        --StructNeRF.quality "$(report_value "$report" options StructNeRF.quality)" \
        --StructNeRF.stereo_num_iterations \
        "$(report_value "$report" options StructNeRF.stereo_num_iterations)" \
        --StructNeRF.num_steps \
        $((4 * $(report_value "$report" options StructNeRF.num_steps)))
    fi
  done
done

"$build_dir/tests/tools/structnerf_results_table" "$output/runs" \
  "planned_$seconds" "cut_off_$seconds"
