#include "ui/map_viewer.h"

#include <QTest>
#include <QWheelEvent>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

StereoMaps MakeMaps() {
  StereoMaps maps{4, 3, std::vector<float>(12, 2.0f), std::vector<float>(36)};
  for (int i = 0; i < 12; ++i) {
    maps.depth[i] += 0.1f * static_cast<float>(i);
    maps.normal[24 + i] = -1;
  }
  maps.depth[5] = 0;
  maps.normal[24 + 5] = 0;
  return maps;
}

TEST(MapViewer, SaysTheValueOfAPixel) {
  QWidget parent;
  parent.resize(400, 300);
  MapViewer viewer(&parent);
  viewer.ShowMap("Depth", MapViewer::Kind::kDepth, MakeMaps());
  EXPECT_EQ(viewer.ValueText(3, 0), "(3, 0): depth 2.3");
  EXPECT_EQ(viewer.ValueText(1, 1), "(1, 1): no value");
  EXPECT_EQ(viewer.ValueText(4, 0), "");
  EXPECT_EQ(viewer.ValueText(0, -1), "");
  viewer.ShowMap("Normal", MapViewer::Kind::kNormal, MakeMaps());
  EXPECT_EQ(viewer.ValueText(3, 0), "(3, 0): normal (0.000, 0.000, -1.000)");
  EXPECT_EQ(viewer.ValueText(1, 1), "(1, 1): no value");
  viewer.ShowMap(
      "Confidence", MapViewer::Kind::kConfidence, {2, 1, {0.25f, 0.875f}, {}});
  EXPECT_EQ(viewer.ValueText(1, 0), "(1, 0): confidence 0.88");
}

TEST(MapViewer, FollowsTheCursorAndZooms) {
  QWidget parent;
  parent.resize(400, 300);
  MapViewer viewer(&parent);
  viewer.ShowMap("Depth", MapViewer::Kind::kDepth, MakeMaps());
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&viewer));
  auto* view = viewer.findChild<QGraphicsView*>();
  const auto* value = viewer.findChild<QLabel*>("value");
  QTest::mouseMove(view->viewport(), view->mapFromScene(2.5, 1.5));
  QTest::qWait(50);
  EXPECT_EQ(value->text(), "(2, 1): depth 2.6");

  const double zoom = view->transform().m11();
  const QPointF center = view->viewport()->rect().center();
  QWheelEvent event(center,
                    view->viewport()->mapToGlobal(center.toPoint()),
                    QPoint(),
                    QPoint(0, 120),
                    Qt::NoButton,
                    Qt::NoModifier,
                    Qt::NoScrollPhase,
                    /*inverted=*/false);
  QCoreApplication::sendEvent(view->viewport(), &event);
  EXPECT_GT(view->transform().m11(), 1.1 * zoom);
}

}  // namespace
}  // namespace structnerf
