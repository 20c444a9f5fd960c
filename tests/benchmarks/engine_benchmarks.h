#pragma once

namespace structnerf {

// Register benchmarks, of the fused engine mostly, on the room of
// sphere_room.h.
//
// Rates with "cpu" in the name are per second of processor time times the
// number of threads: what as many free processors would give.

// Training steps: every preset, one and two threads; against threads, rays per
// step, and table size.
void RegisterTrainingBenchmarks();

// Forward only: rays of training, and full views.
void RegisterRenderingBenchmarks();

// Depth error, samples per ray and their spacing against the step.
void RegisterConvergenceBenchmarks();

// Samples per ray and depth error against the step on the scene file that the
// environment variable STRUCTNERF_SCENE names, if it does.
void RegisterSceneBenchmarks();

// The networks alone, as a share of the peak rate.
void RegisterNetworkBenchmarks();

// Matching of slanted windows (nerf/stereo).
void RegisterStereoBenchmarks();

// The training step against the same engine in LibTorch operations.
void RegisterOracleBenchmarks();

}  // namespace structnerf
