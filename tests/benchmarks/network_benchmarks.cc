#include "nerf/engine/fused_network.h"
#include "nerf/engine/ray_tile.h"
#include "nerf/util/cpu_time.h"
#include "nerf/util/random.h"
#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/trained_room.h"

#include <benchmark/benchmark.h>

namespace structnerf {
namespace {

void FillRandomly(AlignedBuffer<float>* buffer) {
  Random random(1);
  for (size_t i = 0; i < buffer->size(); ++i) {
    (*buffer)[i] = random.NextFloat() - 0.5f;
  }
}

// Both networks on one tile, every sample with colour.
void Network(benchmark::State& state, const FieldOptions& field) {
  const FieldLayout layout(field, Eigen::Vector3f::Ones());
  constexpr size_t kNumSamples = 16 * kMaxTileRays;
  FusedNetwork network(layout);
  network.SetParameters(InitialParameters(layout, 1.0f, 1).network.data());
  FusedNetwork::Buffers buffers(layout, kMaxTileRays, kNumSamples);
  for (AlignedBuffer<float>* buffer : {&buffers.encoding,
                                       &buffers.direction,
                                       &buffers.d_color,
                                       &buffers.d_raw_density}) {
    FillRandomly(buffer);
  }
  std::vector<uint32_t> samples;
  std::vector<uint32_t> rays;
  for (uint32_t s = 0; s < kNumSamples; ++s) {
    samples.push_back(s);
    rays.push_back(s / 16);
  }
  const FusedNetwork::ActiveSamples active{
      samples.data(), rays.data(), kNumSamples};
  std::vector<float> gradient(layout.num_network_parameters);
  const double cpu_before = ThreadCpuSeconds();
  for (auto _ : state) {
    network.ForwardDensity(kNumSamples, &buffers);
    network.ForwardColor(active, kMaxTileRays, &buffers);
    network.Backward(
        active, kMaxTileRays, kNumSamples, &buffers, gradient.data());
    benchmark::DoNotOptimize(gradient.data());
  }
  const double cpu_seconds = ThreadCpuSeconds() - cpu_before;
  const double num_samples =
      static_cast<double>(state.iterations()) * kNumSamples;
  const double flops = num_samples * NetworkFlops(layout, 1.0) / cpu_seconds;
  state.counters["GFLOP/s"] = 1e-9 * flops;
  state.counters["of_peak"] = flops / MeasuredRates(layout, 1).flops;
}

}  // namespace

void RegisterNetworkBenchmarks() {
  for (const int hidden_width : {32, 64}) {
    FieldOptions field = PresetEngineOptions("medium", 1).field;
    field.hidden_width = hidden_width;
    benchmark::RegisterBenchmark(
        ("network/width:" + std::to_string(hidden_width)).c_str(),
        [field](benchmark::State& state) { Network(state, field); })
        ->Unit(benchmark::kMicrosecond);
  }
}

}  // namespace structnerf
