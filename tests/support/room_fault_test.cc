// Every fault of the room shows what it is meant to show.

#include "tests/support/image_geometry.h"
#include "tests/support/synthetic_room.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Two thirds of the usual size, to be quick.
constexpr int kWidth = 216;
constexpr int kHeight = 162;

SyntheticRoom RoomWith(const RoomFault fault) {
  SyntheticRoomOptions options;
  options.fault = fault;
  options.width = kWidth;
  options.height = kHeight;
  return MakeSyntheticRoom(options);
}

double FaultyShare(const SyntheticRoom& room, const int image_idx) {
  int num_faulty = 0;
  int num_rays = 0;
  for (double y = 2; y < kHeight; y += 4) {
    for (double x = 2; x < kWidth; x += 4) {
      num_faulty +=
          CastIntoRoom(room, image_idx, Eigen::Vector2d(x, y)).is_faulty;
      ++num_rays;
    }
  }
  return num_faulty / static_cast<double>(num_rays);
}

int NumViewsWithFault(const SyntheticRoom& room, const double min_share) {
  int count = 0;
  for (size_t i = 0; i < room.images.size(); ++i) {
    count += FaultyShare(room, static_cast<int>(i)) > min_share;
  }
  return count;
}

// Right points of the sparse model on the faulty surface.
int NumFaultyPoints(const SyntheticRoom& room) {
  int count = 0;
  for (const SyntheticPoint& point : room.points) {
    const int image_idx = point.track[0].image_idx;
    count += !point.is_wrong &&
             CastIntoRoom(room,
                          image_idx,
                          room::ProjectPoint(
                              room, room.images[image_idx], point.true_xyz))
                 .is_faulty;
  }
  return count;
}

double MeanGray(const RgbImage& image) {
  double sum = 0;
  for (const uint8_t value : image.data) {
    sum += value;
  }
  return sum / image.data.size();
}

double GreenAt(const RgbImage& image, const Eigen::Vector2d& xy) {
  const int col = static_cast<int>(xy.x());
  const int row = static_cast<int>(xy.y());
  return image.data[3 * (row * image.width + col) + 1];
}

TEST(RoomFault, NamesGoBothWays) {
  EXPECT_EQ(RoomFaultFromName("none"), RoomFault::kNone);
  EXPECT_EQ(RoomFaultFromName("chair_slats"), RoomFault::kChairSlats);
  EXPECT_EQ(RoomFaultFromName("wrong_point_cluster"),
            RoomFault::kWrongPointCluster);
  try {
    RoomFaultFromName("rain");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("rain"));
    EXPECT_THAT(error.what(), testing::HasSubstr("exposure_jump"));
  }
}

TEST(RoomFault, DarkGlossyFront) {
  const SyntheticRoom room = RoomWith(RoomFault::kDarkGlossyFront);
  EXPECT_GE(NumViewsWithFault(room, 0.03), 15);
  EXPECT_EQ(NumFaultyPoints(room), 0);
  // Dark, and not the same from everywhere: neighbouring views disagree on the
  // brightness of one surface point by more than noise and exposure explain.
  double sum = 0;
  double sum_differences = 0;
  int count = 0;
  for (int i = 0; i < 19; ++i) {
    const SyntheticImage& next = room.images[i + 1];
    for (double y = 2; y < kHeight; y += 4) {
      for (double x = 2; x < kWidth; x += 4) {
        const RoomHit hit = CastIntoRoom(room, i, Eigen::Vector2d(x, y));
        if (!hit.is_faulty || !room::IsInView(room, next, hit.xyz)) {
          continue;
        }
        const Eigen::Vector2d xy = room::ProjectPoint(room, next, hit.xyz);
        if ((CastIntoRoom(room, i + 1, xy).xyz - hit.xyz).norm() > 1e-6) {
          continue;
        }
        const double here = GreenAt(room.images[i].pixels, {x, y});
        sum += here;
        sum_differences += std::abs(GreenAt(next.pixels, xy) - here);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_LT(sum / count, 70);
  EXPECT_GT(sum_differences / count, 3);
}

TEST(RoomFault, BlankWallTwoViews) {
  const SyntheticRoom room = RoomWith(RoomFault::kBlankWallTwoViews);
  EXPECT_EQ(NumViewsWithFault(room, 0), 2);
  EXPECT_EQ(NumViewsWithFault(room, 0.3), 2);
  EXPECT_EQ(NumFaultyPoints(room), 0);
  // The two views are tied to the others.
  for (const size_t image_idx : {18, 19}) {
    const auto& observations = room.images[image_idx].observations;
    EXPECT_GT(std::count_if(observations.begin(),
                            observations.end(),
                            [](const SyntheticObservation& observation) {
                              return observation.point_idx >= 0;
                            }),
              10);
  }
}

TEST(RoomFault, ChairSlats) {
  const SyntheticRoom room = RoomWith(RoomFault::kChairSlats);
  EXPECT_GE(NumViewsWithFault(room, 0.005), 8);
  // Along a line across the back, slats and what is behind them take turns.
  int most_changes = 0;
  for (int y = 0; y < kHeight; y += 3) {
    int num_changes = 0;
    bool was_faulty = false;
    for (int x = 0; x < kWidth; ++x) {
      const bool is_faulty =
          CastIntoRoom(room, 17, Eigen::Vector2d(x, y)).is_faulty;
      num_changes += is_faulty != was_faulty;
      was_faulty = is_faulty;
    }
    most_changes = std::max(most_changes, num_changes);
  }
  EXPECT_GE(most_changes, 12);
}

TEST(RoomFault, ObjectAndWallOneSegment) {
  const SyntheticRoom room = RoomWith(RoomFault::kObjectAndWallOneSegment);
  EXPECT_GE(NumViewsWithFault(room, 0.02), 8);
  EXPECT_EQ(NumFaultyPoints(room), 0);
  // Across the board's upper edge depth jumps and brightness does not.
  const auto object_at = [&](const double x, const double y) {
    return CastIntoRoom(room, 8, Eigen::Vector2d(x + 0.5, y + 0.5)).object;
  };
  int num_edges = 0;
  int num_invisible = 0;
  for (int x = 0; x < kWidth; ++x) {
    for (int y = 10; y < kHeight - 10; ++y) {
      const RoomHit above = CastIntoRoom(room, 8, Eigen::Vector2d(x + 0.5, y));
      const RoomHit below =
          CastIntoRoom(room, 8, Eigen::Vector2d(x + 0.5, y + 1));
      if (above.object == "wall_north" && below.is_faulty &&
          object_at(x, y - 4) == above.object &&
          object_at(x, y + 4) == below.object) {
        EXPECT_GT(above.depth - below.depth, 0.2);
        const RgbImage& image = room.images[8].pixels;
        num_invisible +=
            std::abs(GreenAt(image, Eigen::Vector2d(x, y - 4)) -
                     GreenAt(image, Eigen::Vector2d(x, y + 4))) < 12;
        ++num_edges;
      }
    }
  }
  EXPECT_GT(num_edges, 20);
  EXPECT_GT(num_invisible, 0.8 * num_edges);
}

TEST(RoomFault, ExposureJump) {
  const SyntheticRoom room = RoomWith(RoomFault::kExposureJump);
  EXPECT_GT(room.images[10].exposure, 1.4 * room.images[9].exposure);
  EXPECT_GT(MeanGray(room.images[10].pixels),
            MeanGray(room.images[9].pixels) + 15);
  EXPECT_EQ(NumViewsWithFault(room, 0), 0);
}

TEST(RoomFault, WrongPointCluster) {
  const SyntheticRoom room = RoomWith(RoomFault::kWrongPointCluster);
  EXPECT_EQ(NumFaultyPoints(room), 0);
  std::map<int, int> counts;  // of wrong points on the poster by first image
  double sum_errors = 0;
  int num_wrong = 0;
  for (const SyntheticPoint& point : room.points) {
    const int image_idx = point.track[0].image_idx;
    const Eigen::Vector3d center = room::CameraCenter(room.images[image_idx]);
    const double factor =
        (point.xyz - center).norm() / (point.true_xyz - center).norm();
    if (point.is_wrong && std::abs(factor - 0.8) < 0.08 &&
        CastIntoRoom(
            room,
            image_idx,
            room::ProjectPoint(room, room.images[image_idx], point.true_xyz))
            .is_faulty) {
      ++counts[image_idx];
      sum_errors += point.error;
      ++num_wrong;
    }
  }
  const auto most = std::max_element(
      counts.begin(), counts.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  ASSERT_NE(most, counts.end());
  EXPECT_GE(most->second, 20);
  EXPECT_LT(sum_errors / num_wrong, 1);
}

}  // namespace
}  // namespace structnerf
