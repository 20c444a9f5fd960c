#pragma once

#include <opencv2/core.hpp>

namespace structnerf {

// Where a grey image is textured: 255, else 0. That is where the root mean
// square of the gradient's magnitude (Sobel 3x3 divided by 8, grey levels per
// pixel) over a window of 11x11 pixels is at least 4. Sensor noise of 3 grey
// levels alone gives 1.8.
cv::Mat1b TextureMask(const cv::Mat1b& image);

}  // namespace structnerf
