#include "colmap_plugin/evaluation/comparison_pictures.h"

#include "colmap_plugin/evaluation/map_differences.h"
#include "colmap_plugin/evaluation/map_pictures.h"
#include "colmap_plugin/image_file.h"

#include <algorithm>

namespace structnerf {
namespace {

// Draws the pictures of one view.
class PictureMaker {
 public:
  PictureMaker(const Comparison& comparison,
               const PictureSources& sources,
               const std::string& name)
      : comparison_(comparison),
        sources_(sources),
        name_(name),
        has_truth_(comparison.is_metric &&
                   std::binary_search(sources.truth->Names().begin(),
                                      sources.truth->Names().end(),
                                      name)) {
    if (has_truth_) {
      true_depth_ = sources.truth->Depth(name);
    }
    for (size_t i = 0; i < 2; ++i) {
      depths_[i] = sources.maps[i]->Depth(name, Workspace(i).map_type);
      if (has_truth_ && depths_[i]) {
        errors_[i] =
            AbsoluteErrors(*depths_[i],
                           Workspace(i).evaluation->scale.metres_per_unit,
                           true_depth_,
                           name,
                           sources.truth);
      }
    }
  }

  std::vector<std::vector<HtmlPicture>> Make() const {
    std::vector<std::vector<HtmlPicture>> rows(2);
    rows[0].push_back(Photograph());
    rows[1].push_back(has_truth_ ? TrueDepth() : Difference());
    for (size_t i = 0; i < 2; ++i) {
      rows[i].push_back(Depth(i));
      rows[i].push_back(Normals(i));
      if (has_truth_) {
        rows[i].push_back(Error(i));
      }
    }
    if (has_truth_) {
      rows[0].push_back(Difference());
      rows[1].push_back(SmallerError());
    }
    return rows;
  }

 private:
  const ComparedWorkspace& Workspace(const size_t i) const {
    return comparison_.workspaces[i];
  }

  HtmlPicture Picture(const std::string& caption,
                      const cv::Mat3b& picture) const {
    if (picture.empty()) {
      return {caption + ": none", "", ""};
    }
    return {caption,
            caption + " of " + name_,
            JpegDataUri(picture, comparison_.options.picture_size)};
  }

  static std::string Caption(const char* what, const size_t i) {
    return std::string(what) + " " + kLetters[i];
  }

  HtmlPicture Photograph() const {
    return Picture(
        "Photograph",
        ReadColorImage(sources_.maps[0]->Workspace().ImagePath(name_)));
  }

  HtmlPicture TrueDepth() const {
    return Picture("True depth",
                   DepthPicture(true_depth_,
                                comparison_.nearest_depth,
                                comparison_.farthest_depth));
  }

  HtmlPicture Depth(const size_t i) const {
    const double scale =
        comparison_.DisplayScale() * (i == 0 ? 1.0 : comparison_.a_per_b);
    return Picture(Caption("Depth", i),
                   depths_[i] ? DepthPicture(scale * depths_[i]->depth,
                                             comparison_.nearest_depth,
                                             comparison_.farthest_depth)
                              : cv::Mat3b());
  }

  HtmlPicture Normals(const size_t i) const {
    const auto maps =
        sources_.maps[i]->DepthAndNormals(name_, Workspace(i).map_type);
    return Picture(Caption("Normals", i),
                   maps ? NormalPicture(maps->normal, maps->width, maps->height)
                        : cv::Mat3b());
  }

  HtmlPicture Error(const size_t i) const {
    return Picture(Caption("Error", i),
                   errors_[i].empty()
                       ? cv::Mat3b()
                       : ErrorPicture(errors_[i], comparison_.largest_error));
  }

  HtmlPicture Difference() const {
    return Picture(
        "Difference of depths",
        depths_[0] && depths_[1]
            ? ErrorPicture(RelativeDifferences(
                               *depths_[0], *depths_[1], comparison_.a_per_b),
                           comparison_.largest_difference)
            : cv::Mat3b());
  }

  HtmlPicture SmallerError() const {
    return Picture(
        "Whose error is smaller",
        errors_[0].empty() || errors_[1].empty()
            ? cv::Mat3b()
            : BalancePicture(
                  errors_[0], errors_[1], comparison_.largest_error));
  }

  const Comparison& comparison_;
  const PictureSources& sources_;
  const std::string name_;
  const bool has_truth_;
  cv::Mat1f true_depth_;  // metres; empty = none
  std::array<std::optional<PredictedDepth>, 2> depths_;
  std::array<cv::Mat1f, 2> errors_;  // empty = none
};

}  // namespace

std::vector<std::vector<HtmlPicture>> MakeComparisonPictures(
    const Comparison& comparison,
    const PictureSources& sources,
    const std::string& name) {
  return PictureMaker(comparison, sources, name).Make();
}

}  // namespace structnerf
