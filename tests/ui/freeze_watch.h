#pragma once

#include <QElapsedTimer>
#include <QTimer>
#include <algorithm>

namespace structnerf {

// For how long at a time windows do not answer, while it lives.
class FreezeWatch {
 public:
  FreezeWatch() {
    QObject::connect(&timer_, &QTimer::timeout, [this]() {
      longest_ = std::max(longest_, since_tick_.restart());
    });
    since_tick_.start();
    timer_.start(10);
  }

  qint64 LongestMilliseconds() const { return longest_; }

 private:
  QTimer timer_;
  QElapsedTimer since_tick_;
  qint64 longest_ = 0;
};

}  // namespace structnerf
