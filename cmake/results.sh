#!/usr/bin/env bash
# Runs methods x scenes x seeds, measures each run, and prints one table.
#   cmake/results.sh OUTPUT_FOLDER METHODS_FILE SCENE_FOLDER...
# METHODS_FILE: a name and options of structnerf_dense on each line, in which PRIOR
# stands for depth maps to go by: the folder SCENE_FOLDER/prior if there is one, else what
# the stage's own field has made of the training images at quality medium (see
# results_methods.txt, results_ablations.txt).
# SCENE_FOLDER holds images, sparse/0 and depth (16-bit PNGs in millimetres); "room"
# stands for the generated room, room:FAULT for one with a fault (structnerf_make_room
# --help lists them), whose faulty part is measured on its own, too. SEEDS=3 is the
# number of runs of each, OPTIONS are more options for all of them, LPIPS_PATH is a
# TorchScript module of LPIPS. Runs whose result is in OUTPUT_FOLDER already are not
# repeated.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 1; }
# shellcheck source=cmake/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

output=$1 methods_file=$2
shift 2
require_different_names "$@"
[ -r "$methods_file" ] || die "the file $methods_file cannot be read"
mapfile -t method_lines < "$methods_file"  # once: it may be a pipe
build_project release colmap-structnerf structnerf_make_room structnerf_results_table >&2
program=$build_dir/colmap_plugin/colmap-structnerf
mkdir -p "$output/runs"
methods=() missing=()

# One run in a folder that goes away; its report and its measurements stay.
run_once() { # scene folder, folder of the result, seed, options
  local scene=$1 result=$2 seed=$3 work
  shift 3
  work=$(mktemp -d "$output/run.XXXXXX")
  mkdir "$work/result"
  if "$program" structnerf_dense --image_path "$scene/images" \
      --input_path "$scene/sparse/0" --output_path "$work/dense" \
      --StructNeRF.test_every 8 --StructNeRF.seed "$seed" "$@" \
      > "$work/log" 2>&1 &&
    "$program" structnerf_eval --workspace_path "$work/dense" \
      --image_path "$scene/images" --input_path "$scene/sparse/0" \
      --ground_truth_path "$scene/depth" ${LPIPS_PATH:+--lpips_path "$LPIPS_PATH"} \
      --output_path "$work/result/eval.json" >> "$work/log" 2>&1 &&
    { [ ! -d "$scene/fault" ] ||
      "$program" structnerf_eval --workspace_path "$work/dense" \
        --image_path "$scene/images" --input_path "$scene/sparse/0" \
        --ground_truth_path "$scene/depth" --ground_truth_mask_path "$scene/fault" \
        --output_path "$work/result/part.json" >> "$work/log" 2>&1; }; then
    cp "$work/dense/structnerf/report.json" "$work/result/"
    mkdir -p "$(dirname "$result")"
    mv "$work/result" "$result"
  else
    missing+=("$result: $(grep -m1 ERROR "$work/log" || tail -n1 "$work/log")")
  fi
  rm -r "$work"
}

# Prints the folder of the depth maps that PRIOR stands for.
prior_of() { # scene folder, its name
  local scene=$1 prior=$output/priors/$2 work
  if [ -d "$scene/prior" ]; then
    echo "$scene/prior"
    return
  fi
  if [ ! -d "$prior" ]; then
    say "$2, depth priors"
    work=$(mktemp -d "$output/run.XXXXXX")
    # Matching would look at photographs that are held out.
    "$program" structnerf_dense --image_path "$scene/images" \
      --input_path "$scene/sparse/0" --output_path "$work/dense" \
      --StructNeRF.test_every 8 --StructNeRF.stereo_num_iterations 0 \
      > "$work/log" 2>&1 || die "no priors: $(tail -n1 "$work/log")"
    mkdir -p "$output/priors"
    mv "$work/dense/stereo/depth_maps" "$prior"
    rm -r "$work"
  fi
  echo "$prior"
}

for scene in "$@"; do
  name=$(basename "$scene")
  if [[ $scene =~ ^room(:(.*))?$ ]]; then
    fault=${BASH_REMATCH[2]:-none}
    name=${scene/:/_}
    scene=$output/$name
    [ -d "$scene" ] ||
      "$build_dir/tests/tools/structnerf_make_room" "$scene" --fault "$fault"
  fi
  [ -d "$scene/sparse/0" ] || die "the scene $scene has no sparse/0"
  methods=()
  for line in "${method_lines[@]}"; do
    read -r method options <<< "$line"
    case "$method" in ''|'#'*) continue ;; esac
    methods+=("$method")
    if [[ $options == *PRIOR* ]]; then
      prior=$(prior_of "$scene" "$name")
      options=${options//PRIOR/$prior}
    fi
    for ((seed = 0; seed < ${SEEDS:-3}; ++seed)); do
      result=$output/runs/$name/$method/$seed
      [ -e "$result" ] && continue
      say "$name, $method, seed $seed"
      # shellcheck disable=SC2086 # options are words
      run_once "$scene" "$result" "$seed" $options ${OPTIONS:-}
    done
  done
done

"$build_dir/tests/tools/structnerf_results_table" "$output/runs" "${methods[@]}"
if [ ${#missing[@]} -gt 0 ]; then
  say "${#missing[@]} results are missing in the table:"
  printf '  %s\n' "${missing[@]}" >&2
  exit 1
fi
