#include "nerf/engine/torch_engine.h"
#include "nerf/util/cpu_time.h"
#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/benchmarks/trained_room.h"

#include <ATen/Parallel.h>
#include <benchmark/benchmark.h>

namespace structnerf {
namespace {

constexpr int kNumRays = 1024;
constexpr int kStepsPerOracleStep = 20;

double ElapsedSeconds() { return ReadClock(CLOCK_MONOTONIC); }

// Steps of both in turn, so that whatever else the machine does hits both.
void CompareWithOracle(benchmark::State& state,
                       const std::string& quality,
                       const int num_threads) {
  at::set_num_threads(num_threads);
  const EngineOptions options = PresetEngineOptions(quality, num_threads);
  TrainedRoom fused(MakeFusedEngine(options), kNumRays);
  TrainedRoom oracle(MakeTorchEngine(options, TorchPrecision::kFloat),
                     kNumRays);
  fused.Train(kStepsPerOracleStep);
  oracle.Train(1);
  double elapsed[2] = {};
  double cpu[2] = {};
  for (auto _ : state) {
    TrainedRoom* const rooms[2] = {&fused, &oracle};
    const int num_steps[2] = {kStepsPerOracleStep, 1};
    for (int i = 0; i < 2; ++i) {
      const double elapsed_before = ElapsedSeconds();
      const double cpu_before = ProcessCpuSeconds();
      rooms[i]->Train(num_steps[i]);
      elapsed[i] += (ElapsedSeconds() - elapsed_before) / num_steps[i];
      cpu[i] += (ProcessCpuSeconds() - cpu_before) / num_steps[i];
    }
  }
  state.counters["times_faster"] = elapsed[1] / elapsed[0];
  state.counters["times_faster_cpu"] = cpu[1] / cpu[0];
}

}  // namespace

void RegisterOracleBenchmarks() {
  for (const int num_threads : {1, 2}) {
    for (const std::string quality : {"low", "medium"}) {
      benchmark::RegisterBenchmark(
          ("oracle/" + quality + "/threads:" + std::to_string(num_threads))
              .c_str(),
          [=](benchmark::State& state) {
            CompareWithOracle(state, quality, num_threads);
          })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
}

}  // namespace structnerf
