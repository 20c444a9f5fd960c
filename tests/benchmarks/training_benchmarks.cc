#include "nerf/util/cpu_time.h"
#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/trained_room.h"

#include <cmath>
#include <numeric>

#include <benchmark/benchmark.h>
#include <malloc.h>

namespace structnerf {
namespace {

// Steps until rays are sampled around a surface.
constexpr int kWarmUpSteps = 150;

constexpr int kNumRays = 1024;

// Share of the peak rate that networks are asked to reach.
constexpr double kNetworkEfficiency = 0.65;

struct Stage {
  EngineStage stage;
  const char* name;
};
constexpr Stage kStages[] = {{EngineStage::kRays, "rays"},
                             {EngineStage::kEncode, "encode"},
                             {EngineStage::kDensityNetwork, "density"},
                             {EngineStage::kComposite, "composite"},
                             {EngineStage::kColorNetwork, "color"},
                             {EngineStage::kLosses, "losses"},
                             {EngineStage::kBackward, "backward"},
                             {EngineStage::kSortGradient, "sort"},
                             {EngineStage::kSumGradient, "sum"},
                             {EngineStage::kUpdateGrid, "adam_grid"},
                             {EngineStage::kUpdateNetwork, "adam_network"},
                             {EngineStage::kObserveDensity, "cache"}};
static_assert(std::size(kStages) == static_cast<size_t>(EngineStage::kCount));

size_t AllocatedBytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

void TrainingStep(benchmark::State& state,
                  const EngineOptions& options,
                  const int num_rays) {
  const size_t bytes_before = AllocatedBytes();
  TrainedRoom room(MakeFusedEngine(options), num_rays);
  room.Train(kWarmUpSteps);
  StepWork step_work;
  step_work.num_touched_entries =
      static_cast<double>(room.CountTouchedEntries());
  state.counters["MB"] =
      1e-6 * static_cast<double>(AllocatedBytes() - bytes_before);

  const WorkCounts work_before = room.Engine().Work();
  const StageSeconds stages_before = room.Engine().Profile();
  const double cpu_before = ProcessCpuSeconds();
  double loss = 0;
  for (auto _ : state) {
    loss = room.Train(1);
  }
  const double cpu_seconds = ProcessCpuSeconds() - cpu_before;
  if (!std::isfinite(loss)) {
    state.SkipWithError("the loss is not finite");
    return;
  }
  const WorkCounts work = room.Engine().Work();
  const double num_samples =
      static_cast<double>(work.num_samples - work_before.num_samples);
  const double num_step_rays =
      static_cast<double>(work.num_rays - work_before.num_rays);
  step_work.num_samples = num_samples / static_cast<double>(state.iterations());
  step_work.color_share = static_cast<double>(work.num_color_samples -
                                              work_before.num_color_samples) /
                          num_samples;
  const int num_threads = options.num_threads;
  const double seconds_per_sample = cpu_seconds / num_samples;
  state.counters["samples/s"] =
      benchmark::Counter(num_samples, benchmark::Counter::kIsRate);
  state.counters["rays/s"] =
      benchmark::Counter(num_step_rays, benchmark::Counter::kIsRate);
  state.counters["cpu_samples/s"] = num_threads / seconds_per_sample;
  const MachineRates& rates =
      MeasuredRates(room.Engine().Layout(), num_threads);
  const auto fraction = [&](const double efficiency) {
    return SecondsPerSample(
               room.Engine().Layout(), rates, step_work, efficiency) /
           seconds_per_sample;
  };
  state.counters["of_roofline"] = fraction(1.0);
  state.counters["of_roofline_65"] = fraction(kNetworkEfficiency);
  state.counters["touched"] = step_work.num_touched_entries;
  state.counters["color_share"] = step_work.color_share;
  state.counters["grad_share"] =
      static_cast<double>(work.num_gradient_samples -
                          work_before.num_gradient_samples) /
      num_samples;

  StageSeconds stages = room.Engine().Profile();
  for (size_t i = 0; i < stages.size(); ++i) {
    stages[i] -= stages_before[i];
  }
  const double total = std::accumulate(stages.begin(), stages.end(), 0.0);
  for (const Stage& stage : kStages) {
    state.counters[std::string("%") + stage.name] =
        100 * stages[static_cast<size_t>(stage.stage)] / total;
  }
}

void Register(const std::string& name,
              const EngineOptions& options,
              const int num_rays) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [options, num_rays](benchmark::State& state) {
                                 TrainingStep(state, options, num_rays);
                               })
      ->Unit(benchmark::kMillisecond)
      ->MeasureProcessCPUTime()
      ->UseRealTime();
}

}  // namespace

void RegisterTrainingBenchmarks() {
  for (const int num_threads : {1, 2}) {
    for (const std::string quality : {"low", "medium", "high"}) {
      Register("train/" + quality + "/threads:" + std::to_string(num_threads),
               PresetEngineOptions(quality, num_threads),
               kNumRays);
    }
  }
  for (const int num_threads : {3, 4}) {
    Register("train_by_threads/" + std::to_string(num_threads),
             PresetEngineOptions("medium", num_threads),
             kNumRays);
  }
  for (const int num_rays : {256, 4096}) {
    Register("train_by_rays/" + std::to_string(num_rays),
             PresetEngineOptions("medium", 2),
             num_rays);
  }
  for (const int log2_table_size : {14, 16, 19}) {
    EngineOptions options = PresetEngineOptions("medium", 2);
    options.field.log2_table_size = log2_table_size;
    Register("train_by_log2_table_size/" + std::to_string(log2_table_size),
             options,
             kNumRays);
  }
}

}  // namespace structnerf
