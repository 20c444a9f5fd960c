#include "nerf/engine/tile_sampling.h"

#include "nerf/field/field_layout.h"

#include <algorithm>

namespace structnerf {
namespace {

// Every second inner edge of the guided rays is drawn anew.
void GuideEdges(const RayTile& rays,
                const int num_samples,
                Random* random,
                float* edges) {
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    if (rays.guide_depth[ray] > 0) {
      float* const ray_edges = edges + ray * (num_samples + 1);
      for (int i = 1; i < num_samples; i += 2) {
        const float z = rays.guide_depth[ray] +
                        rays.guide_deviation[ray] * random->NextNormal();
        ray_edges[i] = std::min(std::max(z, rays.near[ray]), rays.far[ray]);
      }
      std::sort(ray_edges + 1, ray_edges + num_samples);
    }
  }
}

}  // namespace

void SampleTile(const RayTile& rays,
                const DensityCache& cache,
                const RaySamplingParameters& parameters,
                Random* random,
                float* edges,
                float* x,
                float* y,
                float* z) {
  PerRay<float> jitter = {};
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    jitter[ray] = random ? random->NextFloat() : 0.5f;
  }
  ChooseIntervals(rays, cache, parameters, jitter, edges);
  const int num_samples = parameters.num_samples;
  if (rays.is_guided && random) {
    GuideEdges(rays, num_samples, random, edges);
  }
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    const float* const ray_edges = edges + ray * (num_samples + 1);
    for (int i = 0; i < num_samples; ++i) {
      const float share = random ? random->NextFloat() : 0.5f;
      const float depth =
          ray_edges[i] + share * (ray_edges[i + 1] - ray_edges[i]);
      const int sample = ray * num_samples + i;
      x[sample] = rays.origin[0][ray] + depth * rays.direction[0][ray];
      y[sample] = rays.origin[1][ray] + depth * rays.direction[1][ray];
      z[sample] = rays.origin[2][ray] + depth * rays.direction[2][ray];
    }
  }
}

void EncodeDirection(const RayTile& rays,
                     const int ray,
                     const int num_harmonics,
                     float* encoding) {
  const float inverse_norm = 1.0f / rays.direction_norm[ray];
  const float x = rays.direction[0][ray] * inverse_norm;
  const float y = rays.direction[1][ray] * inverse_norm;
  const float z = rays.direction[2][ray] * inverse_norm;
  const float harmonics[kMaxNumHarmonics] = {0.28209479f,
                                             0.48860251f * y,
                                             0.48860251f * z,
                                             0.48860251f * x,
                                             1.09254843f * x * y,
                                             1.09254843f * y * z,
                                             0.31539157f * (3 * z * z - 1),
                                             1.09254843f * x * z,
                                             0.54627422f * (x * x - y * y)};
  std::copy(harmonics, harmonics + num_harmonics, encoding);
  std::fill(encoding + num_harmonics, encoding + kDirectionWidth, 0.0f);
}

}  // namespace structnerf
