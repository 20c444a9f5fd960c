// Measures the fused engine against what the machine can do and against
// LibTorch. Options are Google Benchmark's, e.g. --benchmark_filter=train.

#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/benchmarks/machine.h"

#include <benchmark/benchmark.h>

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return EXIT_FAILURE;
  }
  structnerf::PrintMachine();
  structnerf::RegisterTrainingBenchmarks();
  structnerf::RegisterRenderingBenchmarks();
  structnerf::RegisterConvergenceBenchmarks();
  structnerf::RegisterSceneBenchmarks();
  structnerf::RegisterNetworkBenchmarks();
  structnerf::RegisterStereoBenchmarks();
  structnerf::RegisterOracleBenchmarks();
  return benchmark::RunSpecifiedBenchmarks() > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
