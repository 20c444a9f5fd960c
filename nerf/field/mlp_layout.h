#pragma once

#include "nerf/field/field_layout.h"
#include "nerf/options.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// Frequencies of the positional encoding of positions and of directions
// (Mildenhall et al. 2020, section 5.1).
constexpr int kPositionFrequencies = 10;
constexpr int kDirectionFrequencies = 4;

// The network sees the scene box as [-1, 1] along its longest side.
constexpr float kMlpUnitsPerFieldUnit = 2;

// Width of the encoding of three coordinates, which are part of it.
constexpr int EncodingWidth(const int num_frequencies) {
  return 3 + 3 * 2 * num_frequencies;
}

// Shapes of NeRF's network (Mildenhall et al. 2020, figure 7 of its supplement,
// as in its code): rectified layers of equal width on the encoded position,
// which comes in a second time after the middle one; from their output density,
// and a vector that, with the encoded direction, gives colour through one
// rectified layer of half the width. Colour may also depend on a latent code of
// the photograph (the paper's appendix, after Martin-Brualla et al. 2021,
// "NeRF in the Wild").
struct MlpLayout {
  explicit MlpLayout(const FieldOptions& options);

  // Index into `trunk` of the layer that sees the position again; the size of
  // `trunk` if none does.
  int skip_layer = 0;
  int latent_size = 0;
  std::vector<LayerLayout> trunk;
  LayerLayout density;  // one output
  LayerLayout feature;  // not rectified
  LayerLayout color_hidden;
  LayerLayout color_output;  // three outputs

  // Of one network; a field has a coarse and, after it, a fine one.
  size_t num_parameters = 0;

  // All layers, in the order of their parameters.
  std::vector<LayerLayout> Layers() const;
};

// Both networks' parameters, coarse before fine, and `num_codes` codes of
// zeros: those of views that are never trained on stay so. Others are uniform
// within 1 / sqrt(number of inputs), as PyTorch's default, which NeRF's
// reimplementations train with. The density's bias makes it start near
// `initial_density` (per field unit), so that no field starts without any light
// stopped, from where rectified density does not recover.
std::vector<float> InitialMlpParameters(const MlpLayout& layout,
                                        int num_codes,
                                        float initial_density,
                                        uint64_t seed);

}  // namespace structnerf
