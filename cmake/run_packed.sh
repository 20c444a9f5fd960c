#!/usr/bin/env bash
# In an archive of cmake/pack_nerf.sh: builds, tests and measures, in ten minutes
# at most.
#   run.sh [RESULT_FOLDER]      (default: results, beside this script)
#
#   RESULT_FOLDER/summary.txt            seconds and outcome of each part
#   RESULT_FOLDER/*.log                  what each part printed
#   RESULT_FOLDER/<scene>_<quality>/     maps, as structnerf_train writes them
#
#   TORCH_DIR      folder of TorchConfig.cmake (default: python3's torch is used)
#   QUALITIES      to train the scenes with (default: "medium high")
#   DEVICES        to train them on (default: cpu, and cuda if there is one)
#   JOBS           (default: all cores)
#   LIMIT_SECONDS  (default: 590)
set -uo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly root
readonly build="$root/build"
readonly jobs=${JOBS:-$(nproc)}
readonly limit=${LIMIT_SECONDS:-590}
num_failed=0

mkdir -p "${1:-$root/results}"
results=$(cd "${1:-$root/results}" && pwd)
readonly results
readonly summary="$results/summary.txt"
: > "$summary"

# part NAME COMMAND ...: runs it until the time is up and notes how it went.
part() {
  local name="$1" begin=$SECONDS outcome=ok
  shift
  if ((SECONDS >= limit)); then
    outcome="out of time"
  else
    timeout --kill-after=5 "$((limit - SECONDS))" "$@" \
      > "$results/$name.log" 2>&1
    case $? in
      0) ;;
      124 | 137) outcome="out of time" ;;
      *) outcome=failed ;;
    esac
  fi
  [ "$outcome" = ok ] || num_failed=$((num_failed + 1))
  printf '%-24s %5d s  %s\n' "$name" $((SECONDS - begin)) "$outcome" |
    tee -a "$summary"
  [ "$outcome" = ok ]
}

# Writes TorchConfig.cmake into a folder for the part of python3's torch that
# works on the processor. Torch's own file asks for all of CUDA's libraries,
# which a machine that only runs Python programs need not have.
describe_torch() {
  mkdir -p "$1"
  python3 - > "$1/TorchConfig.cmake" << 'PYTHON'
import os
import torch

root = os.path.dirname(torch.__file__)
abi = int(torch.compiled_with_cxx11_abi())
version = tuple(int(part) for part in torch.__version__.split(".")[:2])
# The headers of later ones refuse C++17.
standard = 17 if version < (2, 12) else 20
print(f"""
add_library(torch_of_python INTERFACE IMPORTED)
set_target_properties(torch_of_python PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES
    "{root}/include;{root}/include/torch/csrc/api/include"
  INTERFACE_COMPILE_DEFINITIONS _GLIBCXX_USE_CXX11_ABI={abi}
  INTERFACE_COMPILE_FEATURES cxx_std_{standard}
  INTERFACE_LINK_LIBRARIES "{root}/lib/libtorch_cpu.so;{root}/lib/libc10.so"
  # What these two need in turn is found when a program starts.
  INTERFACE_LINK_OPTIONS -Wl,--allow-shlib-undefined)
set(TORCH_LIBRARIES torch_of_python)
""")
PYTHON
}

configure() {
  local torch_dir=${TORCH_DIR:-}
  if [ -z "$torch_dir" ]; then
    torch_dir="$root/torch"
    describe_torch "$torch_dir" || return
  fi
  # A compiler that the project does not know may warn of what others do not.
  cmake -S "$root/source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_FLAGS=-w -DSTRUCTNERF_COLMAP=OFF -DTorch_DIR="$torch_dir" \
    -DEigen3_DIR="$root/prefix/share/eigen3/cmake" \
    -DHWY_DIR="$(dirname "$root"/prefix/lib/*/cmake/hwy/hwy-config.cmake)" \
    -DGTest_DIR="$(dirname "$root"/prefix/lib/*/cmake/GTest/GTestConfig.cmake)" \
    -Dbenchmark_DIR="$(dirname \
      "$root"/prefix/lib/*/cmake/benchmark/benchmarkConfig.cmake)"
}

# The kernels' tests, which are skipped where a card cannot be used.
test_card() {
  local program
  for program in "$build"/tests/nerf/nerf_cuda_*_test; do
    "$@" "$program" || return
  done | tee "$results/card_tests.txt" || return
  ! grep -q SKIPPED "$results/card_tests.txt"
}

export -f configure describe_torch test_card
export root build results
{
  echo "processor: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores"
  command -v nvidia-smi > /dev/null &&
    nvidia-smi --query-gpu=name,memory.total,driver_version --format=csv,noheader
} | tee -a "$summary"

part configure bash -c configure || exit 1
part build ninja -C "$build" -j "$jobs" || exit 1
part test ctest --test-dir "$build" -j "$jobs" --output-on-failure
part benchmark "$build/tests/benchmarks/structnerf_benchmarks" \
  --benchmark_filter=^train/ --benchmark_min_time=0.5
devices=${DEVICES:-cpu}
if ! command -v nvidia-smi > /dev/null; then
  :
elif ! grep -q '^STRUCTNERF_CUDA:BOOL=ON' "$build/CMakeCache.txt"; then
  echo "the card is not used: CMake found no nvcc of version 12 or later" |
    tee -a "$summary"
else
  devices=${DEVICES:-cuda cpu}
  part card bash -o pipefail -c test_card
  if command -v compute-sanitizer > /dev/null; then
    part memcheck bash -o pipefail -c \
      'test_card compute-sanitizer --error-exitcode 1'
  fi
fi
for scene in "$root"/scenes/*; do
  [ -f "$scene" ] || continue
  for quality in ${QUALITIES:-medium high}; do
    for device in $devices; do
      name="$(basename "${scene%.*}")_${quality}_$device"
      if part "$name" "$build/nerf/tools/structnerf_train" \
        --scene_path "$scene" --output_path "$results/$name" \
        --StructNeRF.quality "$quality" --StructNeRF.device "$device"; then
        grep -E '^(Training|Maps|Pixels):' "$results/$name.log" |
          tee -a "$summary"
      fi
    done
  done
done
[ "$num_failed" -eq 0 ]
