#include "tests/benchmarks/roofline_probe.h"

#include "nerf/util/aligned_buffer.h"
#include "nerf/util/cpu_time.h"
#include "nerf/util/median.h"

#include <cstdint>
#include <thread>
#include <vector>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/benchmarks/roofline_probe.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Chains of multiply-adds, enough to hide the latency of two units.
constexpr size_t kNumChains = 10;

// Returns the number of floating-point operations done.
double MultiplyAdd(const size_t num_rounds, float* sink) {
  const hn::ScalableTag<float> d;
  using V = hn::VFromD<decltype(d)>;
  const V factor = hn::Set(d, 0.999f);
  const V term = hn::Set(d, 1e-3f);
  V chains[kNumChains];
  for (size_t i = 0; i < kNumChains; ++i) {
    chains[i] = hn::Iota(d, static_cast<float>(i));
  }
  for (size_t round = 0; round < num_rounds; ++round) {
    for (V& chain : chains) {
      chain = hn::MulAdd(chain, factor, term);
    }
  }
  V sum = hn::Zero(d);
  for (const V& chain : chains) {
    sum = hn::Add(sum, chain);
  }
  *sink += hn::GetLane(hn::SumOfLanes(d, sum));
  return 2.0 * kNumChains * hn::Lanes(d) * num_rounds;
}

const char* Name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {
namespace {

HWY_EXPORT(MultiplyAdd);
HWY_EXPORT(Name);

constexpr int kNumRounds = 9;

// Runs `work(thread)` on all threads at once, several times, and returns the
// median of what it gives per second of processor time.
template <typename Work>
double MedianRate(const int num_threads, const Work& work) {
  std::vector<double> rates;
  for (int round = 0; round < kNumRounds; ++round) {
    std::vector<double> thread_rates(num_threads);
    std::vector<std::thread> threads;
    for (int thread = 0; thread < num_threads; ++thread) {
      threads.emplace_back([&, thread] {
        const double begin = ThreadCpuSeconds();
        const double amount = work(thread);
        thread_rates[thread] = amount / (ThreadCpuSeconds() - begin);
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    rates.insert(rates.end(), thread_rates.begin(), thread_rates.end());
  }
  return Median(&rates);
}

// Keeps the compiler from dropping what was computed.
volatile float probe_sink;

}  // namespace

double RooflineProbe::ClockRate() const {
  return MedianRate(num_threads_, [](const int thread) {
    constexpr uint64_t kNumAdditions = 40000000;
    uint64_t sum = thread;
    for (uint64_t i = 0; i < kNumAdditions; ++i) {
      sum += i;
      // Neither folded into a closed form nor turned into vectors.
      asm volatile("" : "+r"(sum));
    }
    probe_sink = static_cast<float>(sum);
    return static_cast<double>(kNumAdditions);
  });
}

double RooflineProbe::PeakFlops() const {
  return MedianRate(num_threads_, [](int) {
    float sink = 0;
    const double amount = HWY_DYNAMIC_DISPATCH(MultiplyAdd)(3000000, &sink);
    probe_sink = sink;
    return amount;
  });
}

double RooflineProbe::RandomLineRate(const size_t num_bytes) const {
  constexpr size_t kLineFloats = 16;
  const size_t num_lines = num_bytes / (kLineFloats * sizeof(float));
  std::vector<AlignedBuffer<float>> buffers(num_threads_);
  for (AlignedBuffer<float>& buffer : buffers) {
    buffer.Allocate(num_lines * kLineFloats);
  }
  return MedianRate(num_threads_, [&](const int thread) {
    constexpr size_t kNumReads = 2000000;
    constexpr size_t kNumStreams = 4;
    const float* const data = buffers[thread].data();
    float sums[kNumStreams] = {};
    uint64_t states[kNumStreams] = {1, 2, 3, 4};
    for (size_t i = 0; i < kNumReads / kNumStreams; ++i) {
      for (size_t j = 0; j < kNumStreams; ++j) {
        states[j] = states[j] * 6364136223846793005ULL + 1442695040888963407ULL;
        const size_t line = ((states[j] >> 32) * num_lines) >> 32;
        sums[j] += data[line * kLineFloats];
      }
    }
    probe_sink = sums[0] + sums[1] + sums[2] + sums[3];
    return static_cast<double>(kNumReads);
  });
}

double RooflineProbe::StreamBandwidth() const {
  constexpr size_t kNumFloats = size_t{32} << 20;
  std::vector<AlignedBuffer<float>> buffers(num_threads_);
  for (AlignedBuffer<float>& buffer : buffers) {
    buffer.Allocate(kNumFloats);
  }
  return MedianRate(num_threads_, [&](const int thread) {
    float* const data = buffers[thread].data();
    for (size_t i = 0; i < kNumFloats; ++i) {
      data[i] += 1.0f;
    }
    probe_sink = data[kNumFloats / 2];
    return 2.0 * kNumFloats * sizeof(float);
  });
}

const char* SimdTargetInUse() { return HWY_DYNAMIC_DISPATCH(Name)(); }

}  // namespace structnerf
#endif  // HWY_ONCE
