#pragma once

#include <cstddef>

#include <hwy/base.h>

namespace structnerf {

// Rounds to IEEE half precision (without instructions for it, towards zero),
// and back.
void HalfFromFloat(const float* from, size_t count, hwy::float16_t* to);
void FloatFromHalf(const hwy::float16_t* from, size_t count, float* to);

}  // namespace structnerf
